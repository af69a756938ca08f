#include "vision/evidence/evidence_accumulator.h"

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <utility>

#include "vision/evidence/calibrated_pairs.h"
#include "vision/evidence/photometric_support.h"
#include "vision/evidence/road_contact.h"
#include "vision/evidence/road_plane.h"
#include "vision/geometry/point_pair.h"
#include "vision/trajectory/ground_bound.h"

namespace egosieve::vision {
namespace {

constexpr double kForgetting = 0.5;   // lambda of (F2)
constexpr double kTempering = 0.7;    // kappa of (F3)
constexpr double kShareMemory = 0.9;  // of the share of movers, per frame
constexpr double kMostDoubt = 1.5;    // bound of the log-likelihood ratio of a static place
constexpr int kEpipolar = static_cast<int>(EvidenceTerm::kEpipolar);
constexpr int kRoad = static_cast<int>(EvidenceTerm::kRoad);

bool IsKnown(cv::Point2f p) { return std::isfinite(p.x) && std::isfinite(p.y); }

// nullopt unless both pictures are given.
std::optional<PhotometricSupport> PicturesOf(const EvidenceFrame& frame) {
  if (frame.grey.empty() || frame.grey_before.empty()) return std::nullopt;
  std::vector<cv::Point2f> befores, nows;
  for (const EvidencePoint& point : frame.points) {
    if (!point.estimates || !IsKnown(point.now) || !IsKnown(point.before)) continue;
    befores.push_back(point.before);
    nows.push_back(point.now);
  }
  return PhotometricSupport(frame.grey_before, frame.grey, befores, nows,
                            frame.world ? frame.world->LineDeviationPixels() : 0.0);
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

// That of the world's motion, if it is known, and those of the views.
std::vector<CalibratedPair> PairsOf(const EvidenceFrame& frame,
                                    const std::optional<PhotometricSupport>& pictures) {
  std::vector<CalibratedPair> pairs;
  if (frame.world) {
    CalibratedPair& pair = pairs.emplace_back();
    pair.motion = *frame.world;
    pair.pictures = frame.pictures;
    for (const EvidencePoint& point : frame.points) {
      pair.places.push_back({point.before.x, point.before.y, point.now.x, point.now.y});
    }
    pair.support = pictures;
  }
  for (const EvidenceView& view : frame.views) pairs.push_back(PairOf(frame, view));
  return pairs;
}

// Step 1. pairs: PairsOf(frame).
void MeasurePairs(const EvidenceFrame& frame, const std::vector<CalibratedPair>& pairs,
                  EvidenceResult& result) {
  std::vector<bool> is_unbounded;
  for (const EvidencePoint& point : frame.points) is_unbounded.push_back(point.is_unbounded);
  const auto ratios = CalibratedLogRatios(pairs, frame.camera, is_unbounded);
  for (size_t k = 0; k < pairs.size(); ++k) {
    for (size_t i = 0; i < frame.points.size(); ++i) {
      if (!ratios[k][i]) continue;
      PointEvidence& point = result.points[i];
      if (k == 0 && frame.world) {
        point.of_pair[kEpipolar] = ratios[k][i];
      } else {
        point.of_views[kEpipolar] = point.of_views[kEpipolar].value_or(0.0) + *ratios[k][i];
      }
    }
  }
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

struct RoadEvidence {
  std::vector<std::optional<double>> log_ratios;  // one per point; nullopt: not measured
  std::vector<GuidedPlace> standing;              // the unfollowed places that are static road
};

// Step 2, the road term of a frame's evidence, from one other picture:
//
//   1. inverse depths of the followed places, and the road plane       road_plane.h
//   2. with both pictures: road among the unfollowed places            guided_match.h
//   3. log-likelihood ratios of all places, by grey levels, (R3)       road_contact.h
//      and ground contacts
//
// A place of 2 for which 3 finds evidence of motion is dropped, because no flow confirms it.
//
// motion: from the other picture, `before`, to the frame's, as for `pictures`. befores: the points'
// places there. Nothing is measured where the ground is not known.
RoadEvidence MeasureRoad(const EvidenceFrame& frame, const TwoViewMotion& motion,
                         const cv::Mat& before, const std::vector<cv::Point2f>& befores,
                         const std::optional<PhotometricSupport>& pictures,
                         const std::vector<cv::Point2f>& unfollowed) {
  RoadEvidence result;
  result.log_ratios.resize(frame.points.size());
  const std::optional<Eigen::Vector3d> level = GroundPlaneOf(motion);
  if (!motion.HasParallax() || !level) return result;
  std::vector<size_t> owners;  // the point of each pair
  std::vector<PointPair> pairs;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    const cv::Point2f now = frame.points[i].now;
    if (!IsKnown(now) || !IsKnown(befores[i]) || frame.points[i].is_unbounded) continue;
    pairs.push_back({befores[i].x, befores[i].y, now.x, now.y});
    owners.push_back(i);
  }
  std::vector<InverseDepth> depths = InverseDepths(frame.camera, motion, pairs);
  for (size_t k = 0; k < owners.size(); ++k) {
    depths[k].is_textured = frame.points[owners[k]].estimates;
  }
  const RoadPlane road = FitRoad(depths, *level);
  std::vector<GuidedPlace> guided;
  std::optional<ContactPictures> contact;
  if (pictures) {
    const double noise = pictures->noise_levels();
    guided = MatchRoad(road, frame.camera, motion, before, frame.grey, noise, unfollowed);
    std::vector<PointPair> added;
    for (const GuidedPlace& place : guided) {
      added.push_back({place.before.x, place.before.y, place.now.x, place.now.y});
    }
    const std::vector<InverseDepth> added_depths = InverseDepths(frame.camera, motion, added);
    pairs.insert(pairs.end(), added.begin(), added.end());
    depths.insert(depths.end(), added_depths.begin(), added_depths.end());
    CompareWithRoad(road, frame.camera, motion, *pictures, pairs, depths);
    contact.emplace(road, frame.camera, motion, before, frame.grey, noise);
  }
  std::vector<cv::Point2f> places;
  for (const PointPair& pair : pairs) {
    places.emplace_back(static_cast<float>(pair.x2), static_cast<float>(pair.y2));
  }
  const std::vector<double> ratios =
      RoadLogRatios(road, depths, places, frame.size, contact ? &*contact : nullptr);
  for (size_t k = 0; k < owners.size(); ++k) result.log_ratios[owners[k]] = ratios[k];
  for (size_t i = 0; i < guided.size(); ++i) {
    if (ratios[owners.size() + i] < kMostDoubt) result.standing.push_back(guided[i]);
  }
  return result;
}

// The same from the longest view ahead, whose depths are the most accurate. pairs: PairsOf(frame).
void MeasureRoadAhead(const EvidenceFrame& frame, const std::vector<CalibratedPair>& pairs,
                      EvidenceResult& result) {
  const CalibratedPair* const views = pairs.data() + (frame.world ? 1 : 0);
  std::optional<size_t> longest;
  for (size_t k = 0; k < frame.views.size(); ++k) {
    const bool is_usable = views[k].pictures > 0 && views[k].motion.HasParallax();
    if (is_usable && (!longest || views[k].pictures > views[*longest].pictures)) longest = k;
  }
  if (!longest) return;
  const CalibratedPair& pair = views[*longest];
  const EvidenceView& ahead = frame.views[*longest];
  std::optional<PhotometricSupport> support;
  if (pair.support) support = pair.support->Reversed();
  const RoadEvidence road =
      MeasureRoad(frame, Inverse(pair.motion), ahead.grey, ahead.places, support, {});
  for (size_t i = 0; i < frame.points.size(); ++i) {
    result.points[i].of_views[kRoad] = road.log_ratios[i];
  }
}

// The term that contributes most to the sum in the sum's direction.
EvidenceTerm Decisive(const std::array<double, kEvidenceTerms>& sums, bool dynamic) {
  const auto chosen = dynamic ? std::max_element(sums.begin(), sums.end())
                              : std::min_element(sums.begin(), sums.end());
  return static_cast<EvidenceTerm>(chosen - sums.begin());
}

// Step 3.
void Fuse(const EvidenceFrame& frame, EvidenceState& next, EvidenceResult& result) {
  std::vector<EvidenceState::Memory> sums(frame.points.size());
  std::vector<double> totals(frame.points.size(), 0.0), judged;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    PointEvidence& evidence = result.points[i];
    const int64_t id = frame.points[i].parent_id;
    const auto memory = std::lower_bound(
        next.memories.begin(), next.memories.end(), id,
        [](const EvidenceState::Memory& m, int64_t wanted) { return m.track_id < wanted; });
    const bool remembered = id >= 0 && memory != next.memories.end() && memory->track_id == id;
    sums[i].track_id = frame.points[i].track_id;
    evidence.judged = remembered;
    std::array<double, kEvidenceTerms> parts{};
    for (int k = 0; k < kEvidenceTerms; ++k) {
      if (remembered) sums[i].sums[k] = kForgetting * memory->sums[k];
      if (evidence.of_pair[k]) sums[i].sums[k] += *evidence.of_pair[k];
      evidence.judged |= evidence.of_pair[k] || evidence.of_views[k];
      double sum = sums[i].sums[k];
      if (evidence.of_views[k]) sum += *evidence.of_views[k];
      if (sum == 0.0) continue;
      parts[k] = VisibleLogRatio(static_cast<EvidenceTerm>(k), kTempering * sum);
      totals[i] += parts[k];
    }
    evidence.decided_by = Decisive(parts, totals[i] > 0);
    if (evidence.judged) judged.push_back(totals[i]);
  }
  if (!judged.empty()) {
    next.mover_share = kShareMemory * next.mover_share +
                       (1 - kShareMemory) * EstimateMoverShare(judged, next.mover_share);
  }
  next.memories.clear();
  for (size_t i = 0; i < frame.points.size(); ++i) {
    PointEvidence& evidence = result.points[i];
    if (!evidence.judged) continue;
    evidence.probability = ProbabilityOf(totals[i], next.mover_share);
    if (sums[i].track_id >= 0) next.memories.push_back(sums[i]);
  }
  std::sort(next.memories.begin(), next.memories.end(),
            [](const auto& a, const auto& b) { return a.track_id < b.track_id; });
}

}  // namespace

EvidenceResult EvidenceAccumulator::Add(const EvidenceFrame& frame) {
  EvidenceState next = state_;
  if (next.size != frame.size) {
    next = {};
    next.size = frame.size;
  }
  next.last_index = frame.index;

  EvidenceResult result;
  result.points.resize(frame.points.size());
  const std::optional<PhotometricSupport> pictures = PicturesOf(frame);
  const std::vector<CalibratedPair> pairs = PairsOf(frame, pictures);
  MeasurePairs(frame, pairs, result);
  if (frame.world) {
    std::vector<cv::Point2f> before;
    for (const EvidencePoint& point : frame.points) before.push_back(point.before);
    RoadEvidence road =
        MeasureRoad(frame, *frame.world, frame.grey_before, before, pictures, frame.unfollowed);
    for (size_t i = 0; i < before.size(); ++i) result.points[i].of_pair[kRoad] = road.log_ratios[i];
    result.standing = std::move(road.standing);
  }
  MeasureRoadAhead(frame, pairs, result);
  Fuse(frame, next, result);

  result.mover_share = next.mover_share;
  result.standing_probability =
      ProbabilityOf(VisibleLogRatio(EvidenceTerm::kEpipolar, kStandingLogRatio), next.mover_share);
  state_ = std::move(next);
  return result;
}

void EvidenceAccumulator::Interrupt() { state_.memories.clear(); }

absl::Status EvidenceAccumulator::Restore(EvidenceState state) {
  const bool sorted =
      std::is_sorted(state.memories.begin(), state.memories.end(),
                     [](const auto& a, const auto& b) { return a.track_id < b.track_id; });
  const bool whole = sorted && state.mover_share > 0 && state.mover_share < 1;
  if (!whole) return absl::InvalidArgumentError("the state of the evidence is not whole");
  state_ = std::move(state);
  return absl::OkStatus();
}

}  // namespace egosieve::vision
