// Whether the stated uncertainty is large where the map is wrong.
//
//   error          e = |v - 65535 t| of a pixel with score v and truth t in {0, 1}
//   sparsification S(f) = mean error of the pixels that remain after the share f with the largest
//                  deviation is removed, divided by the mean error of all; pixels of equal
//                  deviation are removed together, in equal parts of error
//   oracle         the same if the pixels with the largest error are removed first
//   AUSE           integral over f from 0 to 1 of S - S_oracle: 0 for a perfect ranking       (1)
//   error AUC      area under the ROC curve of the deviation as a score for "the pixel is wrong at
//                  the threshold"                                                             (2)
//
// Integer histograms, mergeable. (1) is integrated in closed form: between two distinct deviations
// the remaining mean is a hyperbola in f.
//
// Reference: Ilg et al., Uncertainty Estimates and Multi-Hypotheses Networks for Optical Flow
// (2018).
#ifndef EGOSIEVE_TOOLS_EVALUATION_UNCERTAINTY_H_
#define EGOSIEVE_TOOLS_EVALUATION_UNCERTAINTY_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "tools/evaluation/roc.h"

namespace egosieve::tools {

struct SparsificationPoint {
  double removed = 0.0;    // f
  double remaining = 1.0;  // S(f)
  double oracle = 1.0;
};

class UncertaintyHistogram {
 public:
  // `threshold`: a pixel with this score or more is called dynamic (roc.h, 3).
  explicit UncertaintyHistogram(int threshold);

  void Add(uint16_t score, uint16_t deviation, bool positive);
  // `other` must have the same threshold.
  void Merge(const UncertaintyHistogram& other);

  // (1); absent without pixels or if no pixel has an error.
  std::optional<double> AreaUnderSparsificationError() const;
  // (2); absent if all pixels are right, or all wrong.
  std::optional<double> ErrorAuc() const { return wrong_.Auc(); }
  // At f = 0, 1/points, ..., 1 - 1/points.
  std::vector<SparsificationPoint> Curve(int points) const;

 private:
  int threshold_;
  std::vector<int64_t> pixels_;      // by deviation
  std::vector<int64_t> error_sums_;  // by deviation
  std::vector<int64_t> errors_;      // pixels by error
  RocHistogram wrong_;               // deviation as the score of being wrong
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_UNCERTAINTY_H_
