// Areas of the windscreen with reflections or dirt, through which the scene is visible. A match
// there mixes the fixed pattern with the scene behind it, and its flow is that of neither.
//
// Few pictures agree with the drive's median M there (fixed_pattern.h), because the scene disturbs
// them. Places with contrast in M that kRecurringShare of the pictures agree with are connected
// to patches. Over the pairs both of whose pictures agree with M at the place, with n_k = 1, (OV2)
// of own_vehicle.h is the log-likelihood ratio of "fixed" against "static scene". A patch is on the
// windscreen if that exceeds kLeastProof on kProvenShare of it.                         (WS1)
//
// Matches within half a window of a patch are affected as well. Pictures are reduced as in
// own_vehicle.h.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/geometry/pinhole.h"
#include "vision/own_vehicle/own_vehicle.h"

namespace egosieve::vision {

// 255 where matches are affected, else 0, of the size of the original pictures; empty if there are
// none. places: of the first pictures of the pairs. seconds: the second pictures, reduced.
cv::Mat1b FindWindscreen(const FixedPlaces& places, const std::vector<cv::Mat1b>& seconds,
                         const std::vector<PairWorld>& worlds, const Pinhole& camera);

}  // namespace egosieve::vision
