#include "vision/evidence/evidence_accumulator.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "vision/evidence/evidence_measurement.h"
#include "vision/evidence/photometric_support.h"

namespace egosieve::vision {
namespace {

constexpr double kForgetting = 0.5;   // lambda of (F2)
constexpr double kTempering = 0.7;    // kappa of (F3)
constexpr double kShareMemory = 0.9;  // of the share of movers, per frame

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
      const auto term = static_cast<EvidenceTerm>(k);
      if (remembered) sums[i].sums[k] = kForgetting * memory->sums[k];
      if (evidence.present[k]) {
        evidence.judged = true;
        sums[i].sums[k] += evidence.log_ratio[k];
      }
      double sum = sums[i].sums[k];
      const std::optional<double> of_views =
          term == EvidenceTerm::kEpipolar ? evidence.views_log_ratio
          : term == EvidenceTerm::kRoad   ? evidence.views_road_log_ratio
                                          : std::nullopt;
      if (of_views) {
        evidence.judged = true;
        sum += *of_views;
      }
      if (sum == 0.0) continue;
      parts[k] = VisibleLogRatio(term, kTempering * sum);
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
  const PhotometricSupport* both = pictures ? &*pictures : nullptr;
  const std::vector<CalibratedPair> views = PairsOfViews(frame);
  MeasurePairs(frame, both, views, result);
  MeasureRoad(frame, both, result);
  MeasureRoadAhead(frame, views, result);
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
