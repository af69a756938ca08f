// The receiver operating characteristic of 16-bit scores, exact, from two histograms.
//
//   AUC = P(s+ > s-) + 1/2 P(s+ = s-)
//       = sum_v p_v (N_<v + n_v / 2) / (P N)                                               (1)
//
// p_v, n_v: positives and negatives with score v; P, N their sums; N_<v the negatives below v. This
// is the Mann-Whitney statistic with ties shared. Counts are exact and merge by addition: over
// frames, threads or machines. 1 MiB an object; Add is O(1), Auc O(65,536).
#ifndef EGOSIEVE_TOOLS_EVALUATION_ROC_H_
#define EGOSIEVE_TOOLS_EVALUATION_ROC_H_

#include <cstdint>
#include <optional>
#include <vector>

namespace egosieve::tools {

class RocHistogram {
 public:
  RocHistogram();

  void Add(uint16_t score, bool positive) { ++(positive ? positives_ : negatives_)[score]; }
  void Merge(const RocHistogram& other);

  int64_t positive_count() const;
  int64_t negative_count() const;
  // Absent without positives or without negatives.
  std::optional<double> Auc() const;

 private:
  std::vector<int64_t> positives_;
  std::vector<int64_t> negatives_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_ROC_H_
