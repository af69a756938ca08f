#include "tools/evaluation/roc.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace egosieve::tools {

std::optional<double> Ratio(int64_t part, int64_t whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

std::optional<double> Confusion::Precision() const {
  return Ratio(true_positives, true_positives + false_positives);
}
std::optional<double> Confusion::Recall() const {
  return Ratio(true_positives, true_positives + false_negatives);
}
std::optional<double> Confusion::FalsePositiveRate() const {
  return Ratio(false_positives, false_positives + true_negatives);
}
std::optional<double> Confusion::Iou() const {
  return Ratio(true_positives, true_positives + false_positives + false_negatives);
}
std::optional<double> Confusion::F() const {
  return Ratio(2 * true_positives, 2 * true_positives + false_positives + false_negatives);
}

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

std::optional<double> RocHistogram::AveragePrecision() const {
  const int64_t positives = positive_count();
  if (positives == 0 || negative_count() == 0) return std::nullopt;
  double sum = 0.0;
  int64_t above = 0, positives_above = 0;
  for (int score = kScores - 1; score >= 0; --score) {
    positives_above += positives_[score];
    above += positives_[score] + negatives_[score];
    if (positives_[score] > 0) {
      sum += static_cast<double>(positives_[score]) * static_cast<double>(positives_above) /
             static_cast<double>(above);  // (2)
    }
  }
  return sum / static_cast<double>(positives);
}

Confusion RocHistogram::At(int threshold) const {
  Confusion c;
  for (int score = 0; score < kScores; ++score) {
    (score >= threshold ? c.true_positives : c.false_negatives) += positives_[score];
    (score >= threshold ? c.false_positives : c.true_negatives) += negatives_[score];
  }
  return c;
}

std::optional<int> RocHistogram::BestThreshold() const {
  const int64_t positives = positive_count();
  if (positives == 0) return std::nullopt;
  int best = kScores;
  double best_iou = 0.0;
  int64_t hits = 0, alarms = 0;
  for (int score = kScores - 1; score >= 0; --score) {
    hits += positives_[score];
    alarms += negatives_[score];
    const double iou = static_cast<double>(hits) / static_cast<double>(positives + alarms);  // (4)
    if (iou >= best_iou) {
      best_iou = iou;
      best = score;
    }
  }
  return best;
}

std::vector<OperatingPoint> RocHistogram::Curve(int max_points) const {
  const int64_t positives = positive_count(), negatives = negative_count();
  if (positives == 0 || negatives == 0) return {};
  std::vector<OperatingPoint> curve = {{kScores, 0.0, 0.0, 1.0}};
  // A step along the curve, whose length is at most 2, so that the points stay within the limit.
  const double step = 2.0 / std::max(1, max_points - 2);
  int64_t hits = 0, alarms = 0;
  for (int score = kScores - 1; score >= 0; --score) {
    if (positives_[score] + negatives_[score] == 0) continue;
    hits += positives_[score];
    alarms += negatives_[score];
    const OperatingPoint point = {score,
                                  static_cast<double>(alarms) / static_cast<double>(negatives),
                                  static_cast<double>(hits) / static_cast<double>(positives),
                                  static_cast<double>(hits) / static_cast<double>(hits + alarms)};
    const OperatingPoint& last = curve.back();
    const bool at_end = hits == positives && alarms == negatives;
    if (at_end ||
        point.false_positive_rate - last.false_positive_rate + point.recall - last.recall >= step) {
      curve.push_back(point);
    }
    if (at_end) break;
  }
  return curve;
}

uint16_t ScoreOf(double probability) {
  return static_cast<uint16_t>(std::lround(std::clamp(probability, 0.0, 1.0) * 65535.0));
}

int ThresholdOf(double probability) {
  return static_cast<int>(std::ceil(std::clamp(probability, 0.0, 1.0) * 65535.0));
}

}  // namespace egosieve::tools
