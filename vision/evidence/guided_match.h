// Road that flow does not follow, found where the camera's motion has it.
//
// Dense flow loses what moves far and changes its size between two frames: the road before the
// camera, first of all. Its plane and the camera's motion say where each place was. With P the
// patch of N = 7 x 7 pixels around it in the current frame and S the frame before, taken through
// the homography of plane and motion, each less its mean p, s,
//
//   |P|^2 >= N (kLeastTexture sigma)^2,   |P - S|^2 <= kMostChange |P|^2                     (M1)
//
// shows that it is road where P has texture in both directions: nothing was searched, and such
// texture does not agree by chance. An edge alone does: it looks the same moved along itself, and
// shows as little as blank asphalt or a blank door. Such places count as road where
//
//   |P|^2 and |P - S|^2 < N (kLeastTexture sigma)^2,   |p - s| <= kMostApart sigma           (M2)
//
// (or P is such an edge, by (M1)), and below, to the lower edge of the picture or the next place
// that is road, there is nothing else and no step of brightness of more than kMostStep sigma: what
// stands on the road ends at an edge. sigma: noise of photometric_support.h.
//
// A search along the epipolar line for what stands on the road finds it, one time in ten on what
// moves; it made labels worse than none. Cost: 0.5 us a place that is looked at.
#ifndef EGOSIEVE_VISION_EVIDENCE_GUIDED_MATCH_H_
#define EGOSIEVE_VISION_EVIDENCE_GUIDED_MATCH_H_

#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/pinhole.h"
#include "vision/evidence/relative_pose.h"
#include "vision/evidence/road_plane.h"

namespace egosieve::vision {

struct GuidedPlace {
  cv::Point2f now, before;
};

// Those of `places`, of the current frame, that are road by (M1) or (M2), column by column. before,
// now: CV_8UC1 of one size; pose: before to now, found; road: found.
std::vector<GuidedPlace> MatchRoad(const RoadPlane& road, const Pinhole& camera,
                                   const RelativePose& pose, const cv::Mat& before,
                                   const cv::Mat& now, double noise_levels,
                                   const std::vector<cv::Point2f>& places);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_GUIDED_MATCH_H_
