// Estimates the camera of a recorded drive in a first pass over some of its pictures.
//
// Pairs of pictures, spread over the drive (drive_pictures.h), show the own vehicle
// (own_vehicle.h). Points on it are left out of the rest: windows of pictures give the focal length
// (bundle_adjustment.h), and the pairs give the direction of travel (travel_prior.h). The first
// pass needs a recording; a live camera has none.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"
#include "vision/geometry/lens.h"
#include "vision/labelling/drive_pictures.h"
#include "vision/own_vehicle/own_vehicle.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {

struct DriveCamera {
  double focal_ratio = 0.0;          // focal length over the image's longer side
  double log_focal_deviation = 0.0;  // standard deviation of the focal length's logarithm
  // With distortion: the rest is then to be estimated from the pictures corrected by it.
  std::optional<Lens> lens;
  int pair_count = 0;  // pairs of pictures for `travel` and `own_vehicle`
  TravelPrior travel;
  // 255 on the own vehicle, else 0; empty: no own vehicle. Of the pictures as they are read.
  cv::Mat1b own_vehicle;
  cv::Mat1b windscreen;  // own_vehicle/windscreen.h, of the corrected pictures
  // M of fixed_pattern.h; empty: too few pictures, or `finds_own_vehicle` is false.
  cv::Mat1b fixed_pattern;
};

struct DriveCameraOptions {
  DrivePicturesOptions pictures;  // no windows are read if focal_ratio is given
  double focal_ratio = 0.0;       // as in DriveCamera, if known; 0: to be estimated
  bool finds_own_vehicle = true;
};

// Reads from `source`, whose next frame is undefined afterwards. Unreadable frames are skipped;
// errors are the source's. The same input gives the same result.
absl::StatusOr<DriveCamera> LearnDriveCamera(FrameSource& source,
                                             const DriveCameraOptions& options);

}  // namespace egosieve::vision
