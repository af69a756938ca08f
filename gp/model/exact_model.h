// Exact Gaussian process regression, learnt online: points are added and removed in batches, and
// the Cholesky factor is updated.
//
//   y_i = 2 p_i - 1 for a label p_i in [0, 1]; else any targets, of k outputs               (EM1)
//   K_y = K + diag(sigma_n^2 + v_i + jitter) = L L^T,  v_i the point's own noise variance   (EM2)
//   alpha = K_y^-1 (Y - H B);  H, B: mean function and its coefficients, with their uncertainty, as
//   in gp/model/regression_weights.h; zero by default
//   mean(x) = alpha^T k* + B^T h(x),  variance of f(x) = k** - |L^-1 k*|^2 + |M^-1 r(x)|^2   (EM3)
//
// The outputs share covariance, noise and therefore the factor: variances and covariances are the
// same for all. Without points the model is the prior.
//
// Points keep the order in which they were added; removal closes the gaps. Every point has an
// identity, which is unique and increasing over the model's lifetime, and the time at which it was
// added, in the caller's unit.
//
// Numerically equal inputs make K + sigma_n^2 I singular to working precision only if sigma_n is
// tiny. If a pivot is refused, the jitter increases by gp/linalg/jitter_sequence.h, whose unit is
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
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/incremental_cholesky.h"
#include "gp/model/float64_posterior.h"
#include "gp/model/point_set.h"
#include "gp/model/posterior.h"
#include "gp/model/regression_weights.h"
#include "gp/model/sample_paths.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

struct Prediction {
  std::vector<double> mean;       // M x k
  std::vector<double> variance;   // of f, M; empty if not requested
  int64_t clamped_variances = 0;  // negative from rounding, set to 0
};

// A model as a value: everything except the factor, which follows from it.
struct ExactModelState {
  Hyperparameters hyperparameters;
  PointSet points;

  absl::Status Validate() const;
};

class ExactModel {
 public:
  // InvalidArgument for a null context or invalid hyperparameters.
  static absl::StatusOr<ExactModel> Create(std::shared_ptr<kernels::Context> context,
                                           const Hyperparameters& hyperparameters);

  // The model of a state, with the factor as after Refactorize. Errors as for Create and Add.
  static absl::StatusOr<ExactModel> Restore(std::shared_ptr<kernels::Context> context,
                                            const ExactModelState& state);

  ExactModel(ExactModel&&) = default;
  ExactModel& operator=(ExactModel&&) = default;

  // inputs: N x D, finite; labels: N, in [0, 1]; otherwise InvalidArgument with row and value.
  // FailedPrecondition if the matrix is not positive definite with the largest jitter. Unchanged
  // after an error. N = 0 is no change.
  absl::Status Add(kernels::ConstMatrixView<double> inputs, absl::Span<const double> labels,
                   int64_t time);
  absl::Status Add(kernels::ConstMatrixView<float> inputs, absl::Span<const double> labels,
                   int64_t time);
  // The same for regression, with any finite targets y instead of labels.
  absl::Status AddTargets(kernels::ConstMatrixView<double> inputs, absl::Span<const double> targets,
                          int64_t time) {
    return AddObservations({inputs, targets}, time);
  }
  // For several outputs, with noise by point. The number of outputs must be that of the model's
  // points.
  absl::Status AddObservations(const Observations& added, int64_t time);

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

  ExactModelState State() const;

  int64_t size() const { return points_.size(); }
  int64_t input_dimension() const { return hyperparameters_.covariance.input_dimension(); }
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  const std::shared_ptr<kernels::Context>& context() const { return context_; }
  // added to sigma_n^2 on the diagonal; 0 unless a pivot was refused.
  double jitter() const { return jitter_; }

  // Views are valid until the next change.
  kernels::ConstMatrixView<double> inputs() const { return points_.view(input_dimension()); }
  absl::Span<const double> targets() const { return points_.targets; }  // n x k; for labels 2 p - 1
  int64_t outputs() const { return points_.outputs; }                   // k
  Observations observations() const { return points_.observations(input_dimension()); }
  absl::Span<const int64_t> identities() const { return points_.identities; }  // increasing
  absl::Span<const int64_t> insertion_times() const { return points_.insertion_times; }
  const IncrementalCholesky& factor() const { return factor_; }
  const RegressionWeights& weights() const { return weights_; }
  absl::Span<const double> alpha() const { return weights_.alpha; }  // n x k

  // Means (EM3) at N x D points on the context's device in float32, N x k; for an empty model the
  // prior's 0.
  absl::StatusOr<std::vector<float>> PredictMean(kernels::ConstMatrixView<float> points) const;
  // The mean at the model's own points, n x k, in float64 and without covariances: y - (sigma_n^2 +
  // v + jitter) alpha; y itself if the mean's coefficients are not determined.
  std::vector<double> PredictOwnMean() const;
  // (EM3) at N x D points, in float64.
  absl::StatusOr<Prediction> Predict(kernels::ConstMatrixView<double> points,
                                     PredictWhat what) const;

  // (W5) of gp/model/regression_weights.h, summed over outputs; 0 for an empty model, NaN if the
  // mean's coefficients are not determined.
  double LogMarginalLikelihood() const;

  // Leave-one-out predictions of the rows (empty: all).
  absl::StatusOr<LeaveOneOut> PredictLeaveOneOut(absl::Span<const int64_t> rows = {}) const;

  // An immutable posterior of the present model. The model is unchanged; the cost is an upload, and
  // for several outputs or mean functions also a copy of the inputs. devices: what it lies on, in
  // place of the model's own context; empty: that one.
  absl::StatusOr<std::shared_ptr<const Posterior>> MakePosterior(
      const SquashParameters& squash, const kernels::DensePosteriorOptions& options = {},
      const kernels::Contexts& devices = {}) const;
  // The same in float64, on the model's own context, which also predicts jointly. It shares the
  // factor until a change of its rows.
  absl::StatusOr<std::shared_ptr<const Float64Posterior>> MakeFloat64Posterior() const;
  // Samples as functions, (PS4) of gp/model/sample_paths.h; of the prior for a model without points.
  absl::StatusOr<std::shared_ptr<const SamplePaths>> DrawPaths(const PathOptions& options) const;

 private:
  ExactModel() = default;

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

  std::shared_ptr<kernels::Context> context_;
  Hyperparameters hyperparameters_;
  IncrementalCholesky factor_;
  double jitter_ = 0.0;
  PointSet points_;
  RegressionWeights weights_;
};

}  // namespace egosieve::gp
