#include "vision/labelling/place_labels.h"

#include <cmath>
#include <utility>

#include "vision/frame/ignored_area.h"
#include "vision/geometry/residual.h"
#include "vision/image/inside.h"
#include "vision/statistics/robust_scale.h"

namespace egosieve::vision {
namespace {

// noise_pixels: s of (L1); the mixture rule replaces it with its sigma.
std::vector<double> Probabilities(const std::vector<double>& distances, MotionModelKind kind,
                                  const FrameLabellerOptions& options, MixtureState& state,
                                  double& noise_pixels) {
  switch (options.label_rule) {
    case LabelRule::kScaledDistance:
      break;
    case LabelRule::kScaledMedian:
      return ScaledMedianLabels(distances, noise_pixels, options.median_multiple);
    case LabelRule::kMixture: {
      MixtureOptions mixture;
      mixture.residual_dimension = kind == MotionModelKind::kFundamental ? 1 : 2;
      mixture.noise_floor_pixels = options.noise_floor_pixels;
      MixtureLabels labels = EstimateMixtureLabels(distances, state, mixture);
      state = labels.state;
      noise_pixels = labels.state.noise_pixels;
      return std::move(labels.probability);
    }
  }
  std::vector<double> scaled;
  for (const double d : distances) scaled.push_back(d / options.paper_distance_pixels);
  return scaled;
}

}  // namespace

void LabelByDistance(const ExtractedFrame& labelled, const std::vector<PointPair>& pairs,
                     const MotionModel& model, const FrameLabellerOptions& options,
                     MixtureState& mixture, LabelledFrame& result) {
  const bool on_first = options.labelled_side == LabelledSide::kFirstFrame;
  const bool paper = options.label_rule == LabelRule::kScaledDistance;
  const std::vector<double> residuals =
      Residuals(model.kind, model.matrix, pairs,
                paper ? EpipolarDistance::kPointToLine : EpipolarDistance::kSampson);
  std::vector<double> distances = residuals;
  if (!paper) {
    std::vector<double> lengths;
    lengths.reserve(pairs.size());
    for (const PointPair& p : pairs) lengths.push_back(std::hypot(p.x2 - p.x1, p.y2 - p.y1));
    ReduceToShortFlow(lengths, options.flow_noise_share, options.noise_floor_pixels, distances);
  }
  result.noise_pixels = RobustScale(distances, options.noise_floor_pixels);
  const std::vector<double> probability =
      Probabilities(distances, model.kind, options, mixture, result.noise_pixels);
  result.labelled = labelled.frame;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const PointPair& p = pairs[i];
    const double x = on_first ? p.x1 : p.x2, y = on_first ? p.y1 : p.y2;
    if (!(probability[i] >= 0 && probability[i] <= 1) || !IsInside(x, y, labelled.grey.size())) {
      ++result.discarded_count;
      continue;
    }
    result.positions.insert(result.positions.end(), {x, y});
    result.other_positions.insert(result.other_positions.end(),
                                  {on_first ? p.x2 : p.x1, on_first ? p.y2 : p.y1});
    result.probability.push_back(probability[i]);
    result.residual_pixels.push_back(residuals[i]);
    result.decided_by.push_back(EvidenceTerm::kEpipolar);
  }
  result.outcome = LabelOutcome::kLabelled;
}

void LabelByEvidence(const ExtractedFrame& frame, const std::vector<TrackedPoint>& points,
                     const MotionModel& model, const EvidenceResult& evidence,
                     const FrameLabellerOptions& options, LabelledFrame& result) {
  result.noise_pixels = evidence.noise_pixels;
  // A distance to a line checks one direction of two: a single place may pass by chance.
  const bool needs_support = model.kind == MotionModelKind::kFundamental;
  const auto add = [&](cv::Point2f now, cv::Point2f before, double probability, EvidenceTerm by) {
    const PointPair pair{before.x, before.y, now.x, now.y};
    result.positions.insert(result.positions.end(), {now.x, now.y});
    const bool paired = std::isfinite(before.x) && model.kind != MotionModelKind::kNone;
    const cv::Point2f other = paired ? before : now;
    result.other_positions.insert(result.other_positions.end(), {other.x, other.y});
    result.probability.push_back(probability);
    result.residual_pixels.push_back(
        paired ? Residuals(model.kind, model.matrix, {pair}, EpipolarDistance::kSampson)[0] : 0.0);
    result.decided_by.push_back(by);
  };
  for (size_t i = 0; i < points.size(); ++i) {
    const PointEvidence& point = evidence.points[i];
    const cv::Point2f now = points[i].evidence.now;
    if (!point.judged || point.own_vehicle || (needs_support && !points[i].is_supported) ||
        !IsInside(now.x, now.y, frame.grey.size())) {
      ++result.discarded_count;
      continue;
    }
    add(now, points[i].evidence.before, point.probability, point.decided_by);
  }
  for (const GuidedPlace& place : evidence.standing) {
    add(place.now, place.before, evidence.standing_probability, EvidenceTerm::kEpipolar);
  }
  const int stride = options.flow_stride_pixels;
  for (int y = stride / 2; y < frame.grey.rows && !options.ignored.empty(); y += stride) {
    for (int x = stride / 2; x < frame.grey.cols; x += stride) {
      if (!IsIgnored(options.ignored, frame.grey.size(), x, y)) continue;
      const cv::Point2f place(static_cast<float>(x), static_cast<float>(y));
      add(place, place, 0.0, EvidenceTerm::kEpipolar);
    }
  }
  result.outcome = LabelOutcome::kLabelled;
}

}  // namespace egosieve::vision
