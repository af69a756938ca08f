// Finds static road where optical flow fails, from the camera's motion and the road plane.
//
// Dense flow loses points that move far and change their size between two frames, above all the
// road close to the camera. The road plane and the camera's motion predict where each place was.
// With P the patch of N = 7 x 7 pixels around it in the current frame, S the patch of the frame
// before, warped by the homography of plane and motion, and p, s their means, which are subtracted,
//
//   |P|^2 >= N (kLeastTexture sigma)^2,   |P - S|^2 <= kMostChange |P|^2                    (GM1)
//
// shows that the place is road, if P has texture in both directions: without a search, such texture
// does not agree by chance. A single edge is not enough: it looks the same when moved along itself,
// like blank asphalt or a blank door. A blank place is one with
//
//   |P|^2 and |P - S|^2 < N (kLeastTexture sigma)^2,   |p - s| <= kMostApart sigma          (GM2)
//
// or with a single edge that satisfies (GM1). A blank place counts as road if all places below it,
// down to the next place that is road or to the lower edge of the picture, are blank too, and their
// brightness changes by no more than kMostStep sigma from one to the next: an object that stands on
// the road ends at an edge. sigma: noise of photometric_support.h.
//
// Objects on the road are not searched for along their epipolar lines. Cost: linear in the places.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/road_plane.h"
#include "vision/geometry/pinhole.h"
#include "vision/geometry/relative_pose.h"

namespace egosieve::vision {

struct GuidedPlace {
  cv::Point2f now, before;
};

// The `places` of the current frame that are road by (GM1) or (GM2), column by column. before, now:
// CV_8UC1 of one size; pose: before to now, found.
std::vector<GuidedPlace> MatchRoad(const RoadPlane& road, const Pinhole& camera,
                                   const RelativePose& pose, const cv::Mat& before,
                                   const cv::Mat& now, double noise_levels,
                                   const std::vector<cv::Point2f>& places);

}  // namespace egosieve::vision
