#include "tools/evaluation/calibration.h"

#include <algorithm>
#include <cmath>

namespace egosieve::tools {

std::optional<Calibration> CalibrationOf(const RocHistogram& scores, int bins) {
  constexpr double kTop = RocHistogram::kScores - 1;
  bins = std::max(bins, 1);
  Calibration result;
  result.bins.resize(bins);
  for (int b = 0; b < bins; ++b) {
    result.bins[b].low = static_cast<double>(b) / bins;
    result.bins[b].high = static_cast<double>(b + 1) / bins;
  }
  int64_t pixels = 0;
  for (int score = 0; score < RocHistogram::kScores; ++score) {
    const int64_t positives = scores.positives(score), negatives = scores.negatives(score);
    if (positives + negatives == 0) continue;
    const double p = score / kTop, weight = static_cast<double>(positives + negatives);
    const double clipped = std::clamp(p, 0.5 / kTop, 1.0 - 0.5 / kTop);
    result.brier += static_cast<double>(positives) * (1.0 - p) * (1.0 - p) +
                    static_cast<double>(negatives) * p * p;
    result.log_loss -= static_cast<double>(positives) * std::log(clipped) +
                       static_cast<double>(negatives) * std::log1p(-clipped);
    ReliabilityBin& bin = result.bins[std::min(static_cast<int>(p * bins), bins - 1)];
    bin.pixels += positives + negatives;
    bin.mean_stated += weight * p;
    bin.positive_share += static_cast<double>(positives);
    pixels += positives + negatives;
  }
  if (pixels == 0) return std::nullopt;
  const double n = static_cast<double>(pixels);
  result.brier /= n;
  result.log_loss /= n;
  for (ReliabilityBin& bin : result.bins) {
    if (bin.pixels == 0) continue;
    result.expected_calibration_error += std::abs(bin.mean_stated - bin.positive_share) / n;
    bin.mean_stated /= static_cast<double>(bin.pixels);
    bin.positive_share /= static_cast<double>(bin.pixels);
  }
  return result;
}

}  // namespace egosieve::tools
