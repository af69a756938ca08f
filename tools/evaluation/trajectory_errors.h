// Errors of an estimated trajectory and focal length. Nothing is aligned: all figures are about
// relative motion in the camera's own axes, so the world's frame and the trajectory's scale have no
// influence.
//
// R_i, c_i: rotation (world from camera) and centre of frame i, at t_i seconds; ^ marks estimates.
//
//   (E1) rotation    angle((R^_i^T R^_j)^T R_i^T R_j) / (t_j - t_i), degrees/s, j the first
//                    frame at least `span_seconds` after i; its median over i. A span of 0 takes
//                    neighbouring frames
//   (E2) direction   angle between R^_i^T (c^_j - c^_i) and R_i^T (c_j - c_i), degrees, j the first
//                    frame after i with |c_j - c_i| > `least_travel_metres`; its median over the i
//                    that have such a j within `travel_seconds`. An estimate that does not travel
//                    is 90 degrees off
//   (E3) focal       100 (f^ / w^) / (f / w) - 100, percent; w is the image's width in pixels
//
// Only frames with both an estimate and a truth count. Quaternions and rotation matrices are made
// orthonormal when they are read.
#ifndef EGOSIEVE_TOOLS_EVALUATION_TRAJECTORY_ERRORS_H_
#define EGOSIEVE_TOOLS_EVALUATION_TRAJECTORY_ERRORS_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

struct CameraPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // world from camera
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();        // in the world, any unit
};

using Trajectory = std::map<int64_t, CameraPose>;  // by frame

struct TimedPose {
  double seconds = 0.0;
  CameraPose pose;
};

// The TUM format: lines `seconds tx ty tz qx qy qz qw`, camera to world; # begins a comment.
// DataLoss, naming the line.
absl::StatusOr<std::vector<TimedPose>> ParseTumTrajectory(absl::string_view text);

// The KITTI format: one line per frame with the 12 numbers of [R c], row by row; line k, from 0, is
// frame k. DataLoss, naming the line.
absl::StatusOr<Trajectory> ParseKittiPoses(absl::string_view text);

// Assigns each pose to the frame with the nearest time, if that is less than half the smallest step
// away; other poses are left out. `frame_seconds`: increasing.
Trajectory ByFrame(const std::vector<TimedPose>& poses,
                   const std::map<int64_t, double>& frame_seconds);

struct TrajectoryErrorOptions {
  double frames_per_second = 10.0;  // of the truth: t_i = i / rate
  double span_seconds = 1.0;
  double least_travel_metres = 0.1;
  double travel_seconds = 1.0;

  absl::Status Validate() const;
};

struct TrajectoryErrors {
  int64_t frames = 0;                         // with an estimate and a truth
  std::optional<double> rotation;             // (E1)
  std::optional<double> rotation_neighbours;  // (E1) with a span of 0
  int64_t travelling = 0;                     // pairs that count for (E2)
  std::optional<double> direction;            // (E2)
};

TrajectoryErrors CompareTrajectories(const Trajectory& estimate, const Trajectory& truth,
                                     const TrajectoryErrorOptions& options);

struct CameraTruth {
  double focal_pixels = 0.0;
  double radial = 0.0;  // k of r_distorted = r (1 + k r^2), r in focal lengths
  double width = 0.0;   // pixels
  double height = 0.0;
  std::optional<double> frames_per_second;
};

// camera.json, of a run or of a drive's truth. DataLoss, naming the field.
absl::StatusOr<CameraTruth> ParseCamera(absl::string_view json);

// (E3), signed.
double FocalErrorPercent(const CameraTruth& estimate, const CameraTruth& truth);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_TRAJECTORY_ERRORS_H_
