// Road that flow does not follow, found where the camera's motion has it.
//
// Dense flow loses what moves far and changes its size between two frames: the road before the
// camera, first of all. Its plane and the camera's motion say where each place was. With P the
// patch of N = 7 x 7 pixels around it in the current frame and S the frame before, taken through
// the homography of plane and motion, each less its mean,
//
//   |P|^2 >= N (kLeastTexture sigma)^2,   |P - S|^2 <= kMostChange |P|^2                     (M1)
//
// shows that it is road: nothing was searched, and texture does not agree by chance. A search along
// the epipolar line for what stands on the road does, one time in ten on what moves; it made labels
// worse than none. sigma: noise of photometric_support.h. Cost: 0.3 us a place.
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

// Those of `places`, of the current frame, that are road by (M1), in their order. before, now:
// CV_8UC1 of one size; pose: before to now, found; road: found.
std::vector<GuidedPlace> MatchRoad(const RoadPlane& road, const Pinhole& camera,
                                   const RelativePose& pose, const cv::Mat& before,
                                   const cv::Mat& now, double noise_levels,
                                   const std::vector<cv::Point2f>& places);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_GUIDED_MATCH_H_
