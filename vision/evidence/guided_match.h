// Places that flow does not follow, found where they would be if they stood still.
//
// Dense flow loses what moves far or changes its size between two frames: the road before the
// camera, cars that are passed. The camera's motion says where such a place may have been. With P
// the patch of N = 7 x 7 pixels around it in the current frame and S the picture before, taken
// through the motion of a plane (the road's; else one at depth 1 / r, parallel to the image), each
// less its mean,
//
//   e = |P - S|^2,   |P|^2 >= N (kLeastTexture sigma)^2                                      (M1)
//   e <= kMostChange |P|^2                                                                   (M2)
//
// shows that it is the same. The road is tried first, for it needs no search. Then r >= 0 is
// searched along the epipolar line in steps of a pixel, up to kNearest. Where places kApart pixels
// or more from the best do nearly as well, it stands still for all that is known, but its depth is
// not known. sigma: noise of photometric_support.h. Cost: 10 us a place that is searched.
#ifndef EGOSIEVE_VISION_EVIDENCE_GUIDED_MATCH_H_
#define EGOSIEVE_VISION_EVIDENCE_GUIDED_MATCH_H_

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/evidence/pinhole.h"
#include "vision/evidence/relative_pose.h"
#include "vision/evidence/road_plane.h"

namespace egosieve::vision {

struct GuidedPlace {
  cv::Point2f now, before;
  bool is_road = false;
  bool has_depth = false;
};

class GuidedMatcher {
 public:
  static constexpr int kRadius = 3, kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
  using Patch = std::array<float, kPixels>;

  // before, now: CV_8UC1 of one size; pose: before to now, found; road: found.
  GuidedMatcher(cv::Mat before, cv::Mat now, const Pinhole& camera, const RelativePose& pose,
                const RoadPlane& road, double noise_levels);

  // Those of `places` that were found, in their order.
  std::vector<GuidedPlace> Match(const std::vector<cv::Point2f>& places) const;

 private:
  std::optional<GuidedPlace> MatchOne(cv::Point2f place) const;
  // p: of the place; most_error: right side of (M2).
  std::optional<GuidedPlace> SearchLine(cv::Point2f place, const Patch& p, double most_error) const;

  cv::Mat before_, now_;
  Pinhole camera_;
  RelativePose back_;
  RoadPlane road_;
  Eigen::Matrix3d road_motion_;  // homography, now to before
  double noise_levels_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_GUIDED_MATCH_H_
