#include "vision/evidence/fusion.h"

#include <algorithm>
#include <cmath>

namespace egosieve::vision {
namespace {

constexpr double kFewestShare = 0.01, kMostShare = 0.5;
constexpr int kShareSteps = 20;

}  // namespace

const char* Name(EvidenceTerm term) {
  switch (term) {
    case EvidenceTerm::kEpipolar:
      return "epipolar";
    case EvidenceTerm::kRoad:
      return "road";
  }
  return "unknown";
}

double VisibleLogRatio(EvidenceTerm term, double ratio) {
  const double hidden = kHiddenShare[static_cast<int>(term)];
  // exp overflows beyond 700; there the hidden share no longer matters.
  if (ratio > 50.0) return ratio + std::log1p(-hidden);
  return std::log(hidden + (1.0 - hidden) * std::exp(ratio));
}

double ProbabilityOf(double log_ratio, double mover_share) {
  return 1.0 / (1.0 + std::exp(-log_ratio - std::log(mover_share / (1.0 - mover_share))));
}

bool Tells(double probability, double mover_share) {
  const auto log_odds = [](double p) { return std::log(p) - std::log1p(-p); };
  return !(std::abs(log_odds(probability) - log_odds(mover_share)) < kLeastEvidence);
}

double EstimateMoverShare(const std::vector<double>& log_ratios, double start) {
  double share = std::clamp(start, kFewestShare, kMostShare);
  if (log_ratios.empty()) return share;
  for (int k = 0; k < kShareSteps; ++k) {
    double sum = 0.0;
    for (const double ratio : log_ratios) sum += ProbabilityOf(ratio, share);
    const double next =
        std::clamp(sum / static_cast<double>(log_ratios.size()), kFewestShare, kMostShare);
    if (std::abs(next - share) < 1e-4) return next;
    share = next;
  }
  return share;
}

}  // namespace egosieve::vision
