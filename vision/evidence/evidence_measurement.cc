#include "vision/evidence/evidence_measurement.h"

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/evidence/calibrated_pairs.h"
#include "vision/evidence/evidence_accumulator.h"
#include "vision/evidence/guided_match.h"
#include "vision/evidence/photometric_support.h"
#include "vision/evidence/road_contact.h"
#include "vision/evidence/road_plane.h"
#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/geometry/relative_pose.h"
#include "vision/trajectory/ground_bound.h"

namespace egosieve::vision {
namespace {

// The road term of a frame's evidence, in three steps:
//
//   1. inverse depths of the followed places, and the road plane       road_plane.h
//   2. with both pictures: road among the unfollowed places            guided_match.h
//   3. log-likelihood ratios of all places, by grey levels, (R3)       road_contact.h
//      and ground contacts
//
// A place of step 2 for which step 3 finds evidence of motion is dropped, because no flow confirms
// it.
struct RoadView {
  Pinhole camera;
  RelativePose pose;  // before to now, with parallax
  cv::Size size;
  std::vector<PointPair> pairs;         // places that flow follows
  std::vector<bool> is_textured;        // one per pair
  std::vector<cv::Point2f> unfollowed;  // places of the current frame where flow failed
  cv::Mat before, now;                  // CV_8UC1 of `size`; not read without `pictures`
  const PhotometricSupport* pictures = nullptr;
  Eigen::Vector3d level = Eigen::Vector3d::Zero();  // m0 of (R2)
};

struct RoadEvidence {
  std::vector<double> log_ratios;     // one per pair
  std::vector<GuidedPlace> standing;  // the unfollowed places that are static road
};

constexpr double kMostDoubt = 1.5;  // bound of the log-likelihood ratio of a static place

void Append(const std::vector<GuidedPlace>& guided, const RoadView& view,
            std::vector<PointPair>& pairs, std::vector<InverseDepth>& depths) {
  std::vector<PointPair> added;
  for (const GuidedPlace& place : guided) {
    added.push_back({place.before.x, place.before.y, place.now.x, place.now.y});
  }
  const std::vector<InverseDepth> added_depths = InverseDepths(view.camera, view.pose, added);
  pairs.insert(pairs.end(), added.begin(), added.end());
  depths.insert(depths.end(), added_depths.begin(), added_depths.end());
}

RoadEvidence EvidenceOf(const RoadView& view) {
  RoadEvidence result;
  std::vector<PointPair> pairs = view.pairs;
  std::vector<InverseDepth> depths = InverseDepths(view.camera, view.pose, pairs);
  for (size_t i = 0; i < depths.size(); ++i) depths[i].is_textured = view.is_textured[i];
  const RoadPlane road = FitRoad(depths, view.level);
  std::vector<GuidedPlace> guided;
  if (view.pictures != nullptr) {
    guided = MatchRoad(road, view.camera, view.pose, view.before, view.now,
                       view.pictures->noise_levels(), view.unfollowed);
    Append(guided, view, pairs, depths);
    CompareWithRoad(road, view.camera, view.pose, *view.pictures, pairs, depths);
  }
  std::vector<cv::Point2f> places;
  for (const PointPair& pair : pairs) {
    places.emplace_back(static_cast<float>(pair.x2), static_cast<float>(pair.y2));
  }
  std::optional<ContactPictures> contact;
  if (view.pictures != nullptr) {
    contact.emplace(road, view.camera, view.pose, view.before, view.now,
                    view.pictures->noise_levels());
  }
  result.log_ratios = RoadLogRatios(road, depths, places, view.size, contact ? &*contact : nullptr);
  for (size_t i = 0; i < guided.size(); ++i) {
    if (result.log_ratios[view.pairs.size() + i] < kMostDoubt) result.standing.push_back(guided[i]);
  }
  result.log_ratios.resize(view.pairs.size());
  return result;
}

PointPair PairOf(const EvidencePoint& point) {
  return {point.before.x, point.before.y, point.now.x, point.now.y};
}

CalibratedPair PairOf(const EvidenceFrame& frame, const EvidenceView& view) {
  CalibratedPair pair;
  pair.motion = view.motion;
  pair.pictures = view.pictures;
  std::vector<cv::Point2f> nows, theres;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    const cv::Point2f now = frame.points[i].now, there = view.places[i];
    pair.places.push_back({now.x, now.y, there.x, there.y});
    if (!frame.points[i].estimates || !IsKnown(there)) continue;
    nows.push_back(now);
    theres.push_back(there);
  }
  if (!frame.grey.empty() && !view.grey.empty()) {
    pair.support.emplace(frame.grey, view.grey, nows, theres, view.motion.LineDeviationPixels());
  }
  return pair;
}

// m0 of (R2), from the ground's speed and the direction of travel, in either picture of the motion.
// nullopt unless both are known and the camera moves forward or back: else the horizon is unknown.
std::optional<Eigen::Vector3d> GroundPlaneOf(const TwoViewMotion& motion) {
  if (!(motion.ground_heights > 0.0) || !motion.travel || !MovesForwardOrBack(*motion.travel)) {
    return std::nullopt;
  }
  const Eigen::Vector3d& tau = *motion.travel;
  return motion.ground_heights * Eigen::Vector3d(0.0, 1.0, -tau(1) / tau(2));
}

// The fields of RoadView that are common to all pairs of pictures; `owners` gets the point of each
// of its pairs. before: one per point, its place in the other picture.
RoadView RoadViewOf(const EvidenceFrame& frame, const Pinhole& camera, const RelativePose& pose,
                    const std::vector<cv::Point2f>& before, std::vector<size_t>& owners) {
  RoadView view;
  view.camera = camera;
  view.pose = pose;
  view.size = frame.size;
  view.now = frame.grey;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    const EvidencePoint& point = frame.points[i];
    if (!IsKnown(point.now) || !IsKnown(before[i]) || point.is_unbounded) continue;
    view.pairs.push_back({before[i].x, before[i].y, point.now.x, point.now.y});
    view.is_textured.push_back(point.estimates);
    owners.push_back(i);
  }
  return view;
}

}  // namespace

std::vector<CalibratedPair> PairsOfViews(const EvidenceFrame& frame) {
  std::vector<CalibratedPair> pairs;
  for (const EvidenceView& view : frame.views) pairs.push_back(PairOf(frame, view));
  return pairs;
}

void MeasurePairs(const EvidenceFrame& frame, const PhotometricSupport* pictures,
                  const std::vector<CalibratedPair>& views, EvidenceResult& result) {
  std::vector<CalibratedPair> pairs;
  if (frame.world) {
    CalibratedPair& pair = pairs.emplace_back();
    pair.motion = *frame.world;
    pair.pictures = frame.pictures;
    for (const EvidencePoint& point : frame.points) pair.places.push_back(PairOf(point));
    if (pictures != nullptr) pair.support = *pictures;
  }
  pairs.insert(pairs.end(), views.begin(), views.end());
  std::vector<bool> is_unbounded;
  for (const EvidencePoint& point : frame.points) is_unbounded.push_back(point.is_unbounded);
  const auto ratios = CalibratedLogRatios(pairs, frame.camera, is_unbounded);
  for (size_t k = 0; k < pairs.size(); ++k) {
    for (size_t i = 0; i < frame.points.size(); ++i) {
      if (!ratios[k][i]) continue;
      PointEvidence& point = result.points[i];
      if (k == 0 && frame.world) {
        point.log_ratio[static_cast<int>(EvidenceTerm::kEpipolar)] = *ratios[k][i];
        point.present[static_cast<int>(EvidenceTerm::kEpipolar)] = true;
      } else {
        point.views_log_ratio = point.views_log_ratio.value_or(0.0) + *ratios[k][i];
      }
    }
  }
}

void MeasureRoad(const EvidenceFrame& frame, const PhotometricSupport* pictures,
                 EvidenceResult& result) {
  if (!frame.world || !frame.world->HasParallax()) return;
  const std::optional<Eigen::Vector3d> level = GroundPlaneOf(*frame.world);
  if (!level) return;
  std::vector<cv::Point2f> before;
  for (const EvidencePoint& point : frame.points) before.push_back(point.before);
  std::vector<size_t> owners;
  RoadView view = RoadViewOf(frame, frame.camera, PoseOf(*frame.world), before, owners);
  view.before = frame.grey_before;
  view.pictures = pictures;
  view.unfollowed = frame.unfollowed;
  view.level = *level;
  RoadEvidence evidence = EvidenceOf(view);
  for (size_t k = 0; k < owners.size(); ++k) {
    PointEvidence& point = result.points[owners[k]];
    point.log_ratio[static_cast<int>(EvidenceTerm::kRoad)] = evidence.log_ratios[k];
    point.present[static_cast<int>(EvidenceTerm::kRoad)] = true;
  }
  result.standing = std::move(evidence.standing);
}

void MeasureRoadAhead(const EvidenceFrame& frame, const std::vector<CalibratedPair>& views,
                      EvidenceResult& result) {
  const CalibratedPair* longest = nullptr;
  for (const CalibratedPair& pair : views) {
    const bool is_usable = pair.pictures > 0 && pair.motion.HasParallax();
    if (is_usable && (longest == nullptr || pair.pictures > longest->pictures)) longest = &pair;
  }
  if (longest == nullptr) return;
  const std::optional<Eigen::Vector3d> level = GroundPlaneOf(longest->motion);
  if (!level) return;
  const EvidenceView& ahead = frame.views[longest - views.data()];
  std::vector<size_t> owners;
  RoadView view =
      RoadViewOf(frame, frame.camera, PoseOf(Inverse(longest->motion)), ahead.places, owners);
  view.level = *level;
  std::optional<PhotometricSupport> support;
  if (longest->support) support = longest->support->Reversed();
  view.before = ahead.grey;
  view.pictures = support ? &*support : nullptr;
  const RoadEvidence evidence = EvidenceOf(view);
  for (size_t k = 0; k < owners.size(); ++k) {
    result.points[owners[k]].views_road_log_ratio = evidence.log_ratios[k];
  }
}

}  // namespace egosieve::vision
