// The camera of a run: learnt in a first pass over the drive and kept in the run folder, from which
// a resumed run takes it.
//
// camera.json, as evaluation/trajectory_errors.h reads it:
//   focal_pixels, width, height
//   log_focal_deviation            how sure the focal length is
//   pairs                          of pictures for the direction of travel and the own vehicle
//   own_vehicle_share              of the image
//   fixed_pattern, windscreen      whether there is a fixed_pattern.png, a windscreen.png
//   travel_direction, travel_concentration, travel_share      vision/trajectory/travel_prior.h
// own_vehicle.png, where there is one: 255 own vehicle, 0 world.
// fixed_pattern.png, likewise: the median of pictures of the drive.
// windscreen.png, likewise: 255 where what is on the windscreen mixes with the world.
#ifndef EGOSIEVE_TOOLS_SEGMENT_RUN_CAMERA_H_
#define EGOSIEVE_TOOLS_SEGMENT_RUN_CAMERA_H_

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/drive_camera.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::tools {

struct RunCamera {
  double focal_ratio = 0.0;  // over the longer side
  vision::TravelPrior travel;
  cv::Mat1b own_vehicle;    // 255 where it is; empty: nowhere
  cv::Mat1b windscreen;     // likewise
  cv::Mat1b fixed_pattern;  // vision/own_vehicle/fixed_pattern.h; empty: not known
  std::string text;         // of camera.json
};

// `source`, of frames of the size given, is left at an undefined frame.
absl::StatusOr<RunCamera> LearnRunCamera(vision::FrameSource& source, cv::Size size,
                                         const vision::DriveCameraOptions& options);

// Of the run in `directory`; nothing where it has none. DataLoss for a damaged file.
absl::StatusOr<std::optional<RunCamera>> ReadRunCamera(const std::string& directory);

absl::Status WriteRunCamera(const std::string& directory, const RunCamera& camera);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_RUN_CAMERA_H_
