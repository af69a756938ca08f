// The road's part in a frame's evidence, step by step:
//
//   1. inverse depths of the places that were followed, and the plane    road_plane.h
//      that they show; else a given one
//   2. with both pictures: road among the places that were not           guided_match.h
//   3. what the pictures, R2 and R3 say of all of them                   road_contact.h
//
// A place of step 2 that step 3 doubts is given up: nothing follows it, so it has no word to say.
#ifndef EGOSIEVE_VISION_EVIDENCE_ROAD_EVIDENCE_H_
#define EGOSIEVE_VISION_EVIDENCE_ROAD_EVIDENCE_H_

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/evidence/guided_match.h"
#include "vision/evidence/photometric_support.h"
#include "vision/evidence/pinhole.h"
#include "vision/evidence/relative_pose.h"
#include "vision/evidence/road_plane.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct RoadView {
  Pinhole camera;
  RelativePose pose;  // before to now, found
  cv::Size size;
  std::vector<PointPair> pairs;         // places that were followed
  std::vector<bool> is_textured;        // one a pair
  std::vector<cv::Point2f> unfollowed;  // places of the current frame that were not
  cv::Mat before, now;                  // CV_8UC1 of `size`; not read without `pictures`
  const PhotometricSupport* pictures = nullptr;
  std::optional<Eigen::Vector3d> plane;  // m of (R1), where flow shows none
};

struct RoadEvidence {
  RoadPlane road;                     // the rest is empty where it was not found
  std::vector<double> log_ratios;     // one a pair
  std::vector<GuidedPlace> standing;  // of those that were not followed
};

RoadEvidence MeasureRoad(const RoadView& view, const RoadSlope& last, uint64_t seed);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_ROAD_EVIDENCE_H_
