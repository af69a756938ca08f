// trajectory.txt of a run: the camera's poses in the TUM format, `seconds tx ty tz qx qy qz qw`,
// camera to world. Lengths as in vision/trajectory/camera_step.h: heights of the camera where the
// ground was seen. One pose a frame of the log; made of its lines alone.
#ifndef EGOSIEVE_TOOLS_SEGMENT_TRAJECTORY_FILE_H_
#define EGOSIEVE_TOOLS_SEGMENT_TRAJECTORY_FILE_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// Empty where no step is known.
std::string TrajectoryText(const std::vector<FrameLine>& lines);

// No file where no step is known.
absl::Status WriteTrajectory(const RunFolder& folder);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_TRAJECTORY_FILE_H_
