#include "tests/vision/evidence/clip_score.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "kernels/base/status_macros.h"
#include "vision/paper/ransac.h"

namespace egosieve::vision {
namespace {

constexpr int64_t kLabelledIds = int64_t{1} << 40;  // beyond those of the tracker

double CalibrationError(const std::vector<double>& moving, const std::vector<double>& resting) {
  constexpr int kBins = 10;
  std::array<double, kBins> sum{}, movers{}, count{};
  const auto add = [&](double p, bool moves) {
    const int bin = std::min(kBins - 1, static_cast<int>(p * kBins));
    sum[bin] += p;
    movers[bin] += moves ? 1 : 0;
    ++count[bin];
  };
  for (const double p : moving) add(p, true);
  for (const double p : resting) add(p, false);
  double error = 0.0;
  for (int bin = 0; bin < kBins; ++bin) error += std::abs(sum[bin] - movers[bin]);
  return error / static_cast<double>(moving.size() + resting.size());
}

}  // namespace

absl::StatusOr<std::vector<ClipMotion>> FundamentalsOf(const LabelledClip& clip, int gap) {
  std::vector<ClipMotion> motions(clip.frames.size());
  for (size_t t = gap; t < clip.frames.size(); ++t) {
    std::vector<PointPair> pairs;
    for (const Track& track : clip.frames[t].features) {
      if (!track.Reaches(gap)) continue;
      const cv::Point2f before = track.places[gap], now = track.places[0];
      pairs.push_back({before.x, before.y, now.x, now.y});
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const RansacResult result,
                              EstimateFundamental(pairs, RansacOptions()));
    motions[t] = {MotionModelKind::kFundamental, result.matrix};
  }
  return motions;
}

absl::StatusOr<ClipScore> ScoreClip(const LabelledClip& clip,
                                    const std::vector<ClipMotion>& motions, int gap,
                                    const EvidenceOptions& options) {
  EGOSIEVE_ASSIGN_OR_RETURN(EvidenceAccumulator accumulator, EvidenceAccumulator::Create(options));
  std::vector<double> moving, resting;
  double milliseconds = 0.0;
  for (size_t t = 0; t < clip.frames.size(); ++t) {
    const LabelledClip::Frame& frame = clip.frames[t];
    EvidenceFrame input;
    input.index = static_cast<int64_t>(t);
    input.gap = gap;
    input.size = clip.size;
    input.motion_model = motions[t].kind;
    input.motion_matrix = motions[t].matrix;
    for (const Track& track : frame.features) input.points.push_back(PointOfTrack(track, gap));
    for (const Track& track : frame.labelled) {
      EvidencePoint point = PointOfTrack(track, gap);
      point.track_id += kLabelledIds;
      if (point.parent_id >= 0) point.parent_id += kLabelledIds;
      point.estimates = false;
      input.points.push_back(point);
    }
    const auto start = std::chrono::steady_clock::now();
    EGOSIEVE_ASSIGN_OR_RETURN(const EvidenceResult result, accumulator.Add(input));
    milliseconds +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    for (size_t i = 0; i < frame.labelled.size(); ++i) {
      if (!frame.labelled[i].Reaches(gap)) continue;
      (frame.moving[i] ? moving : resting)
          .push_back(result.points[frame.features.size() + i].probability);
    }
  }
  ClipScore score;
  score.auc = AreaUnderCurve(moving, resting);
  score.calibration_error = CalibrationError(moving, resting);
  score.moving = static_cast<int64_t>(moving.size());
  score.resting = static_cast<int64_t>(resting.size());
  score.milliseconds = milliseconds / static_cast<double>(clip.frames.size());
  return score;
}

}  // namespace egosieve::vision
