// The road term of a frame's evidence, in three steps:
//
//   1. inverse depths of the followed places, and the road plane       road_plane.h
//      fitted to them; if none is found, a given plane
//   2. with both pictures: road among the unfollowed places            guided_match.h
//   3. log-likelihood ratios of all places, by grey levels, (R2)       road_contact.h
//      and ground contacts
//
// A place of step 2 for which step 3 finds evidence of motion is dropped, because no flow confirms
// it.
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
  std::vector<PointPair> pairs;         // places that flow follows
  std::vector<bool> is_textured;        // one per pair
  std::vector<cv::Point2f> unfollowed;  // places of the current frame where flow failed
  cv::Mat before, now;                  // CV_8UC1 of `size`; not read without `pictures`
  const PhotometricSupport* pictures = nullptr;
  std::optional<Eigen::Vector3d> plane;  // m of (R1), used if none is found in `pairs`
};

struct RoadEvidence {
  RoadPlane road;                     // if not found, the other fields are empty
  std::vector<double> log_ratios;     // one per pair
  std::vector<GuidedPlace> standing;  // the unfollowed places that are static road
};

RoadEvidence MeasureRoad(const RoadView& view, const RoadSlope& last, uint64_t seed);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_ROAD_EVIDENCE_H_
