// Binary truth against 16-bit scores: two histograms from which all ranking metrics and all metrics
// at a threshold follow exactly.
//
//   p_v, n_v: positives and negatives with score v; P, N their sums; P_>=v, N_>=v from v upwards
//
//   AUC = P(s+ > s-) + 1/2 P(s+ = s-) = sum_v p_v (N_<v + n_v / 2) / (P N)                 (1)
//   AP  = sum_v (p_v / P) precision(v),  precision(v) = P_>=v / (P_>=v + N_>=v)            (2)
//   a pixel is called positive at threshold v if its score is v or more                    (3)
//   IoU = TP / (TP + FP + FN),  F = 2 TP / (2 TP + FP + FN)                                (4)
//
// (1) is the Mann-Whitney statistic with ties shared. (2) is scikit-learn's
// average_precision_score: steps, not trapezoids. F = 2 IoU / (1 + IoU), so one threshold is the
// best for both. Counts are exact and merge by addition: over frames, threads or machines. Memory:
// 1 MiB per object. Add is O(1), all else O(65,536).
#ifndef EGOSIEVE_TOOLS_EVALUATION_ROC_H_
#define EGOSIEVE_TOOLS_EVALUATION_ROC_H_

#include <cstdint>
#include <optional>
#include <vector>

namespace egosieve::tools {

// part / whole; nothing if whole is 0.
std::optional<double> Ratio(int64_t part, int64_t whole);

// Counts at a threshold. A ratio is absent if its denominator is 0.
struct Confusion {
  int64_t true_positives = 0;
  int64_t false_positives = 0;
  int64_t false_negatives = 0;
  int64_t true_negatives = 0;

  std::optional<double> Precision() const;
  std::optional<double> Recall() const;
  std::optional<double> FalsePositiveRate() const;
  std::optional<double> Iou() const;  // (4)
  std::optional<double> F() const;    // (4)
};

// One operating point of the ROC and precision-recall curves.
struct OperatingPoint {
  int threshold = 0;  // (3); 65536: nothing is called positive
  double false_positive_rate = 0.0;
  double recall = 0.0;
  double precision = 1.0;  // 1 by convention if nothing is called positive
};

class RocHistogram {
 public:
  static constexpr int kScores = 1 << 16;

  RocHistogram();

  void Add(uint16_t score, bool positive) { ++(positive ? positives_ : negatives_)[score]; }
  void Merge(const RocHistogram& other);

  int64_t positive_count() const;
  int64_t negative_count() const;
  int64_t positives(int score) const { return positives_[score]; }
  int64_t negatives(int score) const { return negatives_[score]; }

  // Absent without positives or without negatives.
  std::optional<double> Auc() const;               // (1)
  std::optional<double> AveragePrecision() const;  // (2)

  Confusion At(int threshold) const;  // (3); threshold from 0 to 65536
  // The lowest threshold with the largest IoU; absent without positives.
  std::optional<int> BestThreshold() const;

  // From "nothing is positive" to "everything is", at most one point per distinct score, thinned to
  // at most `max_points` points of nearly even spacing along the ROC curve; both ends are kept.
  // Empty without positives or without negatives.
  std::vector<OperatingPoint> Curve(int max_points) const;

 private:
  std::vector<int64_t> positives_;
  std::vector<int64_t> negatives_;
};

// The 16-bit score of a probability, and the smallest score that is not below the probability.
uint16_t ScoreOf(double probability);
int ThresholdOf(double probability);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_ROC_H_
