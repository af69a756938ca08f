// trajectory.txt of a run: the camera's poses in the TUM format, `seconds tx ty tz qx qy qz qw`,
// camera to world. Lengths are as in vision/trajectory/camera_step.h: in heights of the camera
// where the ground was visible. One pose per frame of the log, made only from its lines.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// Empty if no step is known.
std::string TrajectoryText(const std::vector<FrameLine>& lines);

// Writes no file if no step is known.
absl::Status WriteTrajectory(const RunFolder& folder);

}  // namespace egosieve::tools
