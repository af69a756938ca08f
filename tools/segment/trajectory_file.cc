#include "tools/segment/trajectory_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/atomic_file.h"
#include "vision/trajectory/camera_step.h"

namespace egosieve::tools {

std::string TrajectoryText(const std::vector<FrameLine>& lines) {
  std::vector<vision::CameraStep> steps;
  steps.reserve(lines.size());
  for (const FrameLine& line : lines) steps.push_back(line.step);
  if (std::none_of(steps.begin(), steps.end(), [](const auto& step) { return step.known; })) {
    return "";
  }
  const std::vector<Eigen::Isometry3d> poses = vision::ChainSteps(steps);
  std::string text = "# seconds tx ty tz qx qy qz qw\n";
  for (size_t k = 0; k < lines.size(); ++k) {
    const Eigen::Vector3d at = poses[k].translation();
    const Eigen::Quaterniond turn(poses[k].rotation());
    absl::StrAppendFormat(&text, "%.6f %.6f %.6f %.6f %.8f %.8f %.8f %.8f\n", lines[k].time_seconds,
                          at(0), at(1), at(2), turn.x(), turn.y(), turn.z(), turn.w());
  }
  return text;
}

absl::Status WriteTrajectory(const RunFolder& folder) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  const std::string text = TrajectoryText(lines);
  if (text.empty()) return absl::OkStatus();
  return WriteFileAtomically(folder.File("trajectory.txt"), text);
}

}  // namespace egosieve::tools
