// The own vehicle: what is fixed in the image all drive long while the world moves. Bonnet,
// dashboard, mirror, time stamp, black borders and reflections in the windscreen.
//
// 1. Candidates. From pictures spread over the drive their median M (fixed_pattern.h). A pixel with
//    contrast in M is a candidate where `agreeing_share` of the pictures agree with it.
//
// 2. Proof. What is far away and straight ahead is fixed as well, and so are lines that lead there.
//    Between a picture k and the next the world at a candidate would move by w_k + n_k r e_k, r >=
//    r_k its inverse depth (w_k by the camera's rotation, e_k by its translation between k and a
//    picture soon after, n_k times as long ago as the next), of which the structure tensor S of M,
//    trace 1, sees a part:
//
//      E = sum_k min(c, min_r |S^(1/2) (w_k + n_k r e_k)|^2 / (2 sigma^2))                  (OV2)
//
//    is the log likelihood ratio of "fixed" against "world". The candidate is own vehicle where
//    E > least_evidence. r_k is that of the ground (ground_bound.h, GB1). Its slope here is a third
//    of the median over static points below the horizon, because the mode does not show between
//    pictures so near in time.                                                              (OV3)
//
// 3. Patches of less than two windows are dropped. Blank parts that own vehicle and the image's
//    border enclose belong to it.
//
// All this on pictures reduced to at most 640 pixels.
#ifndef EGOSIEVE_VISION_OWN_VEHICLE_OWN_VEHICLE_H_
#define EGOSIEVE_VISION_OWN_VEHICLE_OWN_VEHICLE_H_

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "vision/evidence/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/own_vehicle/fixed_pattern.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

struct OwnVehicleOptions {
  int fewest_pictures = 12;         // with fewer there is no own vehicle; at least 3
  FixedPatternOptions pattern;      // its most_shift_pixels is sigma as well
  double agreeing_share = 0.8;      // in (0, 1]
  double least_contrast = 2.5;      // deviation in the window, grey levels; less is blank; positive
  double least_evidence = 12.0;     // positive
  double most_pair_evidence = 4.0;  // c, of one pair; positive

  absl::Status Validate() const;
};

// The world between a picture and one soon after.
struct PairWorld {
  TwoViewMotion motion;
  double times = 1.0;         // n of (OV2); cameras turn to and fro, but travel on
  double ground_slope = 0.0;  // g of (OV3)
  size_t picture = 0;         // k, among all pictures
};

// (OV3) from the places that `motion` was estimated from.
double LeastGroundSlope(const std::vector<PointPair>& pairs, const TwoViewMotion& motion,
                        const Pinhole& camera);

// What step 1 found, in the reduced picture's pixels.
struct FixedPlaces {
  enum Kind : uint8_t { kBlank = 0, kChanging = 1, kFixed = 2 };
  cv::Size image;                   // of the whole pictures
  cv::Mat1b kind;                   // of the reduced picture; empty: too few pictures
  std::vector<cv::Mat1b> agreeing;  // 255 where a picture agrees with M, else 0; one a picture
  cv::Mat1f s_xx, s_xy, s_yy;       // S
  cv::Mat1b median;                 // M

  // Whether the place, in pixels of the whole picture, is a candidate.
  bool IsFixed(double x, double y) const;
};

// reduced: ReducedPicture() of pictures of the size `image`. `options` must be valid.
FixedPlaces FindFixedPlaces(const std::vector<cv::Mat1b>& reduced, cv::Size image,
                            const OwnVehicleOptions& options);

// Step 2: 255 at those of `candidates` where E > least_evidence, else 0. both_agree: for each pair,
// where both its pictures agree with M; then no other pairs count at a place, and n_k is 1.
cv::Mat1b ProvenPlaces(const cv::Mat1b& candidates, const FixedPlaces& places,
                       const std::vector<PairWorld>& worlds, const Pinhole& camera,
                       const OwnVehicleOptions& options,
                       const std::vector<cv::Mat1b>* both_agree = nullptr);

// A mask of the reduced picture's size at that of the image; empty where nothing is set.
cv::Mat1b OfTheImage(const cv::Mat1b& reduced, cv::Size image);

// Steps 2 and 3: 255 where the own vehicle is, else 0, of the size of the image; empty where it is
// nowhere. Motions that were not found are passed over. `camera` is that of the whole image.
cv::Mat1b ProveOwnVehicle(const FixedPlaces& places, const std::vector<PairWorld>& worlds,
                          const Pinhole& camera, const OwnVehicleOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_OWN_VEHICLE_OWN_VEHICLE_H_
