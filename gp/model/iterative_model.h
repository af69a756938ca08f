// Exact Gaussian process regression without a factor, for more points than 8 n^2 bytes allow: the
// weights of the mean are found by conjugate gradients (gp/linalg/conjugate_gradients.h) on
//
//   K_y alpha_c = y_c,   K_y = K + D,   D = diag(sigma_n^2 + v_i)                            (IM1)
//   mean_c(x) = alpha_c.k*                                                                   (IM2)
//   |error of mean_c(x)| <= sqrt(k**) / sigma_n residual |y_c|                               (IM3)
//
// with products K_y v that compute K anew, tile by tile (MultiplyCovariance), in one pass for all k
// outputs. The preconditioner is the DTC of gp/model/sparse_solution.h, a pivoted
// Cholesky factorisation of K of rank m:
//
//   M = V V^T + D,   M^-1 = D^-1 - D^-1 V A^-1 V^T D^-1,   V, A: (SP1), (SP3)                (IM4)
//
// K - V V^T is positive semidefinite, so M^-1 K_y has eigenvalues in [1, 1 + |K - V V^T| /
// sigma_n^2]: few iterations, as long as m inducing inputs explain K up to the noise.
//
// (IM3) follows from k*.K_y^-1 k* <= k** and r.K_y^-1 r <= |r|^2 / sigma_n^2 for the residual's
// vector r. The model has means alone, of the zero mean function: variances, samples,
// probabilities, likelihoods and left-out points need a factor (NeedsFactor).
//
// Changes only replace points or hyperparameters; the weights are computed where they are first
// needed and then kept. They depend on points, hyperparameters, options and the weights of Restore
// alone.
//
// Cost: 2 n m^2 flops for M; per iteration n^2 / 2 covariances, 2 k n^2 and 4 k n m flops. Memory:
// 8 n (D + m + 7 k) bytes and 8 MiB; 8 n (D + k) once the weights are there.
//
// References: Gibbs & MacKay (1997), "Efficient implementation of Gaussian processes"; Harbrecht,
// Peters & Schneider (2012), "On the low-rank approximation by the pivoted Cholesky decomposition";
// Gardner et al. (2018), "GPyTorch: blackbox matrix-matrix Gaussian process inference". Not
// thread-safe; the posteriors of MakePosterior are.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/calibration/leave_one_out.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/conjugate_gradients.h"
#include "gp/model/point_set.h"
#include "gp/model/regression_model.h"
#include "gp/model/regression_weights.h"
#include "gp/model/sample_paths.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

// Of 512, 1024 and 2048 the one with the least time of processors: 5.4, 4.9 and 5.8 s by
// bench/peers/many_points.py --methods=product --points=12000 --dimensions=2, on two cores.
inline constexpr int64_t kProductTile = 1024;

// Products of a covariance matrix that is never stored:
//
//   out_c = (K + diag(d)) v_c,   K_ij = k(x_i, x_j)                                          (KP1)
//
// Tiles of K's lower triangle, kProductTile rows and columns each, are computed one after another
// by kernels/ops/covariance_matrix.h in float64 and used twice, as K is symmetric. Cost: n^2 / 2
// covariances and 2 k n^2 multiply-adds for k rows of v. Memory: 8 MiB for the tile, and kProductTile k
// values for each group of its rows. The bits do not depend on the number of threads. x: n x D, finite;
// diagonal: n; v, out: k x n.
absl::Status MultiplyCovariance(kernels::Context& context,
                                const kernels::CovarianceParameters& covariance,
                                kernels::ConstMatrixView<double> x,
                                absl::Span<const double> diagonal,
                                kernels::ConstMatrixView<double> v,
                                kernels::MatrixView<double> out);

struct IterativeModelOptions {
  int64_t rank = 512;                  // m, at most
  ConjugateGradientOptions gradients;  // tolerance: of the residual of (IM1)

  absl::Status Validate() const;
};

class IterativeModel : public RegressionModel {
 public:
  // InvalidArgument for a null context, invalid hyperparameters or options; Unimplemented for a
  // mean function.
  static absl::StatusOr<IterativeModel> Create(std::shared_ptr<kernels::Context> context,
                                               const Hyperparameters& hyperparameters,
                                               const IterativeModelOptions& options = {});

  // The model of a state. alpha: n x k values that the iterations start from, such as those of
  // weights(); empty: 0. They are checked by a product, so that they may come from any source.
  static absl::StatusOr<IterativeModel> Restore(std::shared_ptr<kernels::Context> context,
                                                const ExactModelState& state,
                                                const IterativeModelOptions& options = {},
                                                std::vector<double> alpha = {});

  // As ExactModel's, including errors, but that K_y is not looked at.
  absl::Status AddObservations(const Observations& added, int64_t time) override;
  absl::Status Remove(absl::Span<const int64_t> rows);
  absl::Status SetHyperparameters(const Hyperparameters& hyperparameters);

  const IterativeModelOptions& options() const { return options_; }

  struct Solution {
    RegressionWeights weights;
    ConjugateGradientReport report;
  };
  // NotPositiveDefinite where the tolerance is not reached: nothing is kept, and the next call
  // tries again.
  absl::StatusOr<std::shared_ptr<const Solution>> Solve() const;
  // How the weights were found, if they are there.
  std::optional<ConjugateGradientReport> report() const;

  // For callers that hold a std::variant of models: NeedsFactor.
  absl::StatusOr<LeaveOneOut> PredictLeaveOneOut() const { return NeedsFactor(); }
  absl::StatusOr<std::shared_ptr<const SamplePaths>> DrawPaths(const PathOptions&) const {
    return NeedsFactor();
  }

 private:
  using RegressionModel::RegressionModel;

  // Means alone; errors as those of Solve.
  absl::StatusOr<PosteriorParts> Parts() const override;

  // The weights, after a change.
  void Forget() {
    solution_ = nullptr;
    start_.clear();
  }

  IterativeModelOptions options_;
  std::vector<double> start_;                         // of Restore
  mutable std::shared_ptr<const Solution> solution_;  // null before the first request
};

}  // namespace egosieve::gp
