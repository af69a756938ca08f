// The posterior of a Gaussian process at one moment, computed in float64: means and variances on
// devices with float64 and their own memory (kernels/ops/float64_sums.h), else on the host, with
// covariances of the device if it has float64. The rest is computed on the host.
//
//   mean(x)                         (W3) of gp/model/regression_weights.h
//   cov(x, x') = k(x, x') - (F k*).(F k*') + (M^-1 r).(M^-1 r'),   variance(x) = cov(x, x)      (FP1)
//   d mean / dx = sum_i alpha_i dk(x, x_i) / dx + B^T dh / dx                                   (FP2)
//   d variance / dx = dk** / dx - 2 sum_i (F^T F k* + W u)_i dk(x, x_i) / dx + 2 u^T dh / dx,
//     u = A^-1 r                                                                                (FP3)
//
// F is L^-1 for a model's factor L, and the R of a sparse model. The outputs share variances and
// covariances.
//
// It shares the model's factor: see IncrementalCholesky::Keep. Cost per query: n (D + 10 + k)
// multiply-adds for the mean, n^2 / 2 more for the variance; memory: inputs and
// weights, and tiles of at most 768 n values, or 48 n and 256 MiB, during a call. A query's result
// does not depend on other queries or threads. Immutable: any number of threads may evaluate.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/normal_samples.h"
#include "gp/model/regression_weights.h"
#include "kernels/base/matrix_view.h"
#include "kernels/ops/float64_sums.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

// FailedPrecondition of a model without a factor (FactorKind::kNone), which has means alone.
absl::Status NeedsFactor();

struct JointPrediction {
  std::vector<double> mean;  // M x k
  AlignedMatrix covariance;  // of f, M x M, symmetric; of each output
};

// Gradients with respect to the inputs, at M points.
struct InputGradients {
  std::vector<double> mean;      // M x k x D
  std::vector<double> variance;  // of f, M x D; empty if not requested
};

struct SampleOptions {
  int64_t count = 1;            // samples of each output
  uint64_t seed = 0;            // the same seed gives the same samples
  bool of_observation = false;  // of y instead of f: with sigma_n^2, without v
};

enum class PredictWhat { kMean, kMeanAndVariance };

class Float64Posterior {
 public:
  // inputs: n x D, copied. `weights` must be determined.
  Float64Posterior(std::shared_ptr<kernels::Context> context,
                   const Hyperparameters& hyperparameters, kernels::ConstMatrixView<double> inputs,
                   const RegressionWeights& weights, SharedFactor factor);

  // queries: M x D, finite, else InvalidArgument; means: M x k; variances of f: M; null: not
  // wanted; without a factor variances are FailedPrecondition, also below. Gives the number of
  // variances that were negative from rounding and are 0.
  absl::StatusOr<int64_t> Evaluate(kernels::ConstMatrixView<double> queries, double* means,
                                   double* variances) const;

  // Also without a factor, on the host: means, and what the uncertain coefficients of the mean add to
  // variances, |M^-1 r|^2 of (W4), M values; null: not wanted.
  absl::Status EvaluateWeights(kernels::ConstMatrixView<double> queries, double* means,
                               double* added_variances) const {
    return SumOnHost(queries, means, added_variances, /*with_factor=*/false);
  }

  // Each at M x D points, else InvalidArgument.
  // Mean and (FP1). Cost: M n^2 + M^2 n flops; memory: M n + M^2 values.
  absl::StatusOr<JointPrediction> PredictJoint(kernels::ConstMatrixView<double> points) const;
  // Samples of it (gp/linalg/normal_samples.h); of the prior for a model without points.
  absl::StatusOr<NormalSamples> Sample(kernels::ConstMatrixView<double> points,
                                       const SampleOptions& options) const;
  // (FP2), (FP3). Cost: M n D k for the mean, 2 M n^2 for the variance.
  absl::StatusOr<InputGradients> PredictGradients(kernels::ConstMatrixView<double> points,
                                                  PredictWhat what) const;

  bool has_factor() const { return factor_.kind != kernels::FactorKind::kNone; }
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  kernels::ConstMatrixView<double> inputs() const {
    return {inputs_.data(), factor_.values.rows, hyperparameters_.covariance.input_dimension()};
  }
  const RegressionWeights& weights() const { return weights_; }
  int64_t outputs() const { return weights_.outputs; }

 private:
  // Means, and variances before they are clamped, or without a factor what is added to them.
  absl::Status SumOnDevice(kernels::ConstMatrixView<double> queries, double* means,
                           double* variances) const;
  absl::Status SumOnHost(kernels::ConstMatrixView<double> queries, double* means, double* variances,
                         bool with_factor) const;
  // What is in the device's memory, from the first prediction there.
  absl::StatusOr<std::shared_ptr<const kernels::Float64Sums>> OnDevice(bool with_variance) const;
  // (FP3), points.rows x D.
  absl::Status VarianceGradients(kernels::ConstMatrixView<double> points,
                                 kernels::MatrixView<double> out) const;

  std::shared_ptr<kernels::Context> context_;
  Hyperparameters hyperparameters_;
  std::vector<double> inputs_;
  RegressionWeights weights_;
  SharedFactor factor_;
  mutable std::mutex mutex_;
  // Guarded by mutex_: without and with the factor.
  mutable std::shared_ptr<const kernels::Float64Sums> means_on_device_, all_on_device_;
};

}  // namespace egosieve::gp
