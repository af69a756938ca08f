#include "tools/evaluation/roc.h"

#include <numeric>

namespace egosieve::tools {
namespace {

constexpr int kScores = 1 << 16;

}  // namespace

RocHistogram::RocHistogram() : positives_(kScores), negatives_(kScores) {}

void RocHistogram::Merge(const RocHistogram& other) {
  for (int score = 0; score < kScores; ++score) {
    positives_[score] += other.positives_[score];
    negatives_[score] += other.negatives_[score];
  }
}

int64_t RocHistogram::positive_count() const {
  return std::accumulate(positives_.begin(), positives_.end(), int64_t{0});
}

int64_t RocHistogram::negative_count() const {
  return std::accumulate(negatives_.begin(), negatives_.end(), int64_t{0});
}

std::optional<double> RocHistogram::Auc() const {
  const double positives = static_cast<double>(positive_count());
  const double negatives = static_cast<double>(negative_count());
  if (!(positives > 0.0 && negatives > 0.0)) {
    return std::nullopt;
  }
  double won = 0.0;
  int64_t below = 0;
  for (int score = 0; score < kScores; ++score) {
    won += static_cast<double>(positives_[score]) *
           (static_cast<double>(below) + 0.5 * static_cast<double>(negatives_[score]));  // (1)
    below += negatives_[score];
  }
  return won / (positives * negatives);
}

}  // namespace egosieve::tools
