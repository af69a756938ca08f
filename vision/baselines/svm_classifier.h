// A support vector machine with a Gaussian kernel (OpenCV's). It gives a decision function.
//
//   f(x) = sum_i alpha_i exp(-gamma |x - x_i|^2) - rho,   f > 0: positive              (SV1)
//
// ChooseSvmParameters takes gamma and C from a small grid by cross-validation: the pair with the
// least sum of the two classes' error rates; of equal ones the smaller gamma and C. Points i, i +
// k, i + 2 k, ... form a fold: the result depends on the points and their order alone.
#ifndef EGOSIEVE_VISION_BASELINES_SVM_CLASSIFIER_H_
#define EGOSIEVE_VISION_BASELINES_SVM_CLASSIFIER_H_

#include <cstdint>
#include <memory>
#include <opencv2/ml.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::vision {

struct SvmParameters {
  double gamma = 2.0;  // positive
  double c = 1.0;      // positive

  absl::Status Validate() const;
};

class SvmClassifier {
 public:
  // inputs: N x D, finite; positive: N, both classes present (FailedPrecondition otherwise).
  static absl::StatusOr<SvmClassifier> Train(kernels::ConstMatrixView<float> inputs,
                                             const std::vector<uint8_t>& positive,
                                             const SvmParameters& parameters);

  // f of (SV1) at M x D points.
  std::vector<double> Decide(kernels::ConstMatrixView<float> queries) const;

 private:
  explicit SvmClassifier(cv::Ptr<cv::ml::SVM> machine) : machine_(std::move(machine)) {}

  cv::Ptr<cv::ml::SVM> machine_;
};

// Decision values by k folds, each from a machine that was trained without the point; 0 if the
// training points of a fold have one class only.
absl::StatusOr<std::vector<double>> CrossValidatedDecisions(kernels::ConstMatrixView<float> inputs,
                                                            const std::vector<uint8_t>& positive,
                                                            const SvmParameters& parameters,
                                                            int folds);

absl::StatusOr<SvmParameters> ChooseSvmParameters(kernels::ConstMatrixView<float> inputs,
                                                  const std::vector<uint8_t>& positive, int folds);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_BASELINES_SVM_CLASSIFIER_H_
