#include "vision/labelling/place_labels.h"

#include <cmath>

#include "vision/frame/ignored_area.h"
#include "vision/geometry/residual.h"
#include "vision/image/inside.h"

namespace egosieve::vision {
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
    if (!point.judged || (needs_support && !points[i].is_supported) ||
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
