// What is on the windscreen: reflections and dirt, through which the world shows. A match there
// mixes what stays in the image with the world behind it, and its flow is that of neither.
//
// Few pictures agree with the drive's median M there (fixed_pattern.h), for the world disturbs
// them. Places with contrast in M that `recurring_share` of the pictures agree with are connected
// to patches. Over the pairs both of whose pictures agree with M at the place, with n_k = 1, (OV2)
// of own_vehicle.h is the log likelihood ratio of "stays in the image" against "world". A patch is
// on the windscreen where that exceeds least_evidence on `proven_share` of it.           (WS1)
//
// Matches mix half a window around it as well. All this on reduced pictures, as there.
#ifndef EGOSIEVE_VISION_OWN_VEHICLE_WINDSCREEN_H_
#define EGOSIEVE_VISION_OWN_VEHICLE_WINDSCREEN_H_

#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/pinhole.h"
#include "vision/own_vehicle/own_vehicle.h"

namespace egosieve::vision {

struct WindscreenOptions {
  double recurring_share = 0.2;  // in (0, 1]
  double proven_share = 0.1;     // in (0, 1]
};

// 255 where matches mix, else 0, of the size of the image; empty where they do nowhere.
// seconds: the second picture of each pair, reduced; `places` is of the first ones. `fixed`, with
// which `places` was made, must be valid.
cv::Mat1b FindWindscreen(const FixedPlaces& places, const std::vector<cv::Mat1b>& seconds,
                         const std::vector<PairWorld>& worlds, const Pinhole& camera,
                         const OwnVehicleOptions& fixed, const WindscreenOptions& options = {});

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_OWN_VEHICLE_WINDSCREEN_H_
