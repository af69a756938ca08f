// Exact Gaussian process regression, learnt online: points are added and removed in batches, and
// the Cholesky factor is updated.
//
//   K_y = K + diag(sigma_n^2 + v_i + jitter) = L L^T,  v_i the point's own noise variance   (EM2)
//   alpha = K_y^-1 (Y - H B);  H, B: mean function and its coefficients, with their uncertainty, as
//   in gp/model/regression_weights.h; zero by default
//   mean(x) = alpha^T k* + B^T h(x),  variance of f(x) = k** - |L^-1 k*|^2 + |M^-1 r(x)|^2   (EM3)
//
// The outputs share covariance, noise and therefore the factor: variances and covariances are the
// same for all. Without points the model is the prior.
//
// Numerically equal inputs make K + sigma_n^2 I singular to working precision only if sigma_n is
// tiny. If a pivot is refused, the jitter increases by gp/linalg/not_positive_definite.h, whose unit is
// the largest k(x_i, x_i), and the factor is rebuilt; jitter() reports it. Setting the
// hyperparameters resets it to zero.
//
// On devices with float64 and their own memory, the factor is rebuilt on the device, also for a
// batch that at least doubles the points. It is then copied to the host, which updates it
// (kernels/ops/exact_regression.h).
//
// Cost: Add of k points k n^2 + k^2 n; Remove 2 k n^2 (or a rebuild, if cheaper);
// SetHyperparameters n^3 / 3 and n^2 / 2 covariances. Memory: one n x n array of float64, and
// another during a rebuild.
//
// A change that fails leaves the model as it was, also if memory is exhausted (std::bad_alloc, or
// ResourceExhausted for the factor). Remove, whose update is in place, allocates all memory first.
//
// If the points do not determine the mean function's coefficients, predictions are
// FailedPrecondition.
//
// References: Rasmussen & Williams (2006), 2.2, 2.7, 5.4.2. Not thread-safe; the posteriors of
// MakePosterior are.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/calibration/leave_one_out.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/incremental_cholesky.h"
#include "gp/model/point_set.h"
#include "gp/model/regression_model.h"
#include "gp/model/regression_weights.h"
#include "gp/model/sample_paths.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

class ExactModel : public RegressionModel {
 public:
  // InvalidArgument for a null context or invalid hyperparameters.
  static absl::StatusOr<ExactModel> Create(std::shared_ptr<kernels::Context> context,
                                           const Hyperparameters& hyperparameters);

  // The model of a state, with the factor as after Refactorize. Errors as for Create and Add.
  static absl::StatusOr<ExactModel> Restore(std::shared_ptr<kernels::Context> context,
                                            const ExactModelState& state);

  ExactModel(ExactModel&&) = default;
  ExactModel& operator=(ExactModel&&) = default;

  // FailedPrecondition if the matrix is not positive definite with the largest jitter. Unchanged
  // after an error.
  absl::Status AddObservations(const Observations& added, int64_t time) override;

  // rows: indices in [0, size()), strictly increasing; otherwise InvalidArgument, unchanged.
  absl::Status Remove(absl::Span<const int64_t> rows);

  // New targets for the model's points, n x k, finite; the factor stays. Otherwise InvalidArgument,
  // unchanged.
  absl::Status SetTargets(kernels::ConstMatrixView<double> targets);

  // Rebuilds the factor. Unchanged after an error (same conditions as Create and Add). The input
  // dimension cannot change while there are points.
  absl::Status SetHyperparameters(const Hyperparameters& hyperparameters);

  // Rebuilds the factor from the points: its bits then depend on points and hyperparameters alone,
  // not on the history. Afterwards a run that continues from a checkpoint agrees with the run that
  // wrote it.
  absl::Status Refactorize();

  // added to sigma_n^2 on the diagonal; 0 unless a pivot was refused.
  double jitter() const { return jitter_; }
  const IncrementalCholesky& factor() const { return factor_; }
  const RegressionWeights& weights() const { return weights_; }
  absl::Span<const double> alpha() const { return weights_.alpha; }  // n x k

  // Means (EM3) at N x D points on the context's device in float32, N x k; for an empty model the
  // prior's 0.
  absl::StatusOr<std::vector<float>> PredictMean(kernels::ConstMatrixView<float> points) const;
  // The mean at the model's own points, n x k, in float64 and without covariances: y - (sigma_n^2 +
  // v + jitter) alpha; y itself if the mean's coefficients are not determined.
  std::vector<double> PredictOwnMean() const;

  // (W5) of gp/model/regression_weights.h, summed over outputs; 0 for an empty model, NaN if the
  // mean's coefficients are not determined.
  double LogMarginalLikelihood() const;

  // Leave-one-out predictions of the rows (empty: all).
  absl::StatusOr<LeaveOneOut> PredictLeaveOneOut(absl::Span<const int64_t> rows = {}) const;

  // Samples as functions, (PS4) of gp/model/sample_paths.h; of the prior for a model without points.
  absl::StatusOr<std::shared_ptr<const SamplePaths>> DrawPaths(const PathOptions& options) const;

 private:
  using RegressionModel::RegressionModel;

  absl::StatusOr<PosteriorParts> Parts() const override;

  // Results that follow from points and hyperparameters.
  struct Solution {
    IncrementalCholesky factor;
    double jitter = 0.0;
    RegressionWeights weights;
  };

  absl::Status AppendToFactor(const Observations& added);
  // The solution for `points` with the first jitter that works, beginning with `jitter`; `refused`:
  // `jitter` has already been refused, so the next larger one is first.
  absl::StatusOr<Solution> Solve(const Hyperparameters& hyperparameters, const PointSet& points,
                                 double jitter, bool refused) const;
  // Takes both; cannot fail.
  void Commit(Solution solution, PointSet points);

  IncrementalCholesky factor_;
  double jitter_ = 0.0;
  RegressionWeights weights_;
};

}  // namespace egosieve::gp
