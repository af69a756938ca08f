// The camera of a recorded drive, learnt in a first pass over some of its pictures.
//
// Pairs of pictures, spread over the drive (drive_pictures.h), tell what of the image is the own
// vehicle (own_vehicle.h). Without it, windows of pictures tell the focal length
// (bundle_adjustment.h), and the pairs the direction of travel (travel_prior.h), which a few
// pictures more of the ground sharpen (ground_direction.h). A recording can be read twice, a live
// camera cannot.
#ifndef EGOSIEVE_VISION_LABELLING_DRIVE_CAMERA_H_
#define EGOSIEVE_VISION_LABELLING_DRIVE_CAMERA_H_

#include <opencv2/core.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/drive_pictures.h"
#include "vision/own_vehicle/own_vehicle.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {

struct DriveCamera {
  double focal_ratio = 0.0;          // focal length over the image's longer side
  double log_focal_deviation = 0.0;  // standard deviation of the focal length's logarithm
  int pair_count = 0;                // pairs of pictures for `travel` and `own_vehicle`
  TravelPrior travel;
  cv::Mat1b own_vehicle;  // 255 where it is, else 0; empty: nowhere
  cv::Mat1b windscreen;   // own_vehicle/windscreen.h, likewise
  // M of fixed_pattern.h; empty: too few pictures, or the own vehicle was not looked for.
  cv::Mat1b fixed_pattern;
};

struct DriveCameraOptions {
  DrivePicturesOptions pictures;  // no windows are read where focal_ratio is given
  double focal_ratio = 0.0;       // of DriveCamera, where it is known; 0: to be learnt
  bool finds_own_vehicle = true;
  OwnVehicleOptions own_vehicle;

  absl::Status Validate() const;
};

// Reads from `source`, whose next frame is undefined afterwards. Frames that cannot be read are
// passed over; errors are the source's. The same for the same input.
absl::StatusOr<DriveCamera> LearnDriveCamera(FrameSource& source,
                                             const DriveCameraOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_DRIVE_CAMERA_H_
