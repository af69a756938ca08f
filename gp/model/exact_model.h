// Exact Gaussian process regression on labels, learnt online: points are added and removed in
// batches, the Cholesky factor follows.
//
//   y_i = 2 p_i - 1 for a label p_i in [0, 1];  prior mean 0                        (M1)
//   L L^T = K + (sigma_n^2 + jitter) I,  alpha = (L L^T)^-1 y                       (M2)
//   mean(x) = k*.alpha,  variance of f(x) = k** - |L^-1 k*|^2                       (M3)
//
// Points keep the order in which they were added; removal closes the gaps. Every point has an
// identity, unique in the model's life and increasing, and the frame in which it was added.
//
// Numerically equal inputs make K + sigma_n^2 I singular to working precision only where sigma_n is
// tiny. Where a pivot is refused, the jitter climbs from 1e-10 sigma_f^2 by tens to 1e-4 sigma_f^2
// and the factor is rebuilt; jitter() reports it. It goes back to zero when the hyperparameters
// are set.
//
// Cost: Add of k points k n^2 + k^2 n; Remove 2 k n^2 (or a rebuild where that is cheaper);
// SetHyperparameters n^3 / 3 and n^2 / 2 covariances. Memory: one n x n array of float64, another
// while a factor is rebuilt.
//
// A change that fails leaves the model as it was, also where it fails because memory runs out
// (std::bad_alloc, or ResourceExhausted for the factor). Remove is not so: its update is in place.
//
// Not thread-safe; MakePosterior gives what is.
#ifndef EGOSIEVE_GP_MODEL_EXACT_MODEL_H_
#define EGOSIEVE_GP_MODEL_EXACT_MODEL_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/calibration/leave_one_out.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/incremental_cholesky.h"
#include "gp/model/point_set.h"
#include "gp/model/posterior.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

struct Prediction {
  std::vector<double> mean;
  std::vector<double> variance;   // of f; empty where it was not asked for
  int64_t clamped_variances = 0;  // negative from rounding, set to 0
};

// A model as a value: everything but the factor, which follows from it.
struct ExactModelState {
  Hyperparameters hyperparameters;
  PointSet points;

  absl::Status Validate() const;
};

enum class PredictWhat { kMean, kMeanAndVariance };

class ExactModel {
 public:
  // InvalidArgument on a null context or invalid hyperparameters.
  static absl::StatusOr<ExactModel> Create(std::shared_ptr<kernels::Context> context,
                                           const Hyperparameters& hyperparameters);

  // A model from its state, as it is after Refactorize. Errors as for Create and Add.
  static absl::StatusOr<ExactModel> Restore(std::shared_ptr<kernels::Context> context,
                                            const ExactModelState& state);

  ExactModel(ExactModel&&) = default;
  ExactModel& operator=(ExactModel&&) = default;

  // inputs: N x D, finite; labels: N, in [0, 1]. InvalidArgument, naming row and value, otherwise;
  // FailedPrecondition where no jitter up to the ladder's end makes the matrix positive definite.
  // Unchanged after an error. N = 0 is no change.
  absl::Status Add(kernels::ConstMatrixView<double> inputs, absl::Span<const double> labels,
                   int64_t frame);
  absl::Status Add(kernels::ConstMatrixView<float> inputs, absl::Span<const double> labels,
                   int64_t frame);
  // The same for regression: any finite targets y instead of labels.
  absl::Status AddTargets(kernels::ConstMatrixView<double> inputs, absl::Span<const double> targets,
                          int64_t frame);

  // rows: indices in [0, size()), strictly increasing. InvalidArgument, unchanged, otherwise.
  absl::Status Remove(absl::Span<const int64_t> rows);

  // Rebuilds the factor. Unchanged after an error (same conditions as Create and Add). The input
  // dimension cannot change once there are points.
  absl::Status SetHyperparameters(const Hyperparameters& hyperparameters);

  // Rebuilds the factor from the points: its bits then depend on points and hyperparameters alone,
  // not on the history. A checkpoint and the run that wrote it go on alike after this.
  absl::Status Refactorize();

  ExactModelState State() const;

  int64_t size() const { return points_.size(); }
  int64_t input_dimension() const { return hyperparameters_.covariance.input_dimension(); }
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  const std::shared_ptr<kernels::Context>& context() const { return context_; }
  // Added to sigma_n^2 on the diagonal; 0 unless a pivot was refused.
  double jitter() const { return jitter_; }

  // Views are valid until the next change.
  kernels::ConstMatrixView<double> inputs() const { return points_.view(input_dimension()); }
  absl::Span<const double> targets() const { return points_.targets; }         // y = 2 p - 1
  absl::Span<const int64_t> identities() const { return points_.identities; }  // increasing
  absl::Span<const int64_t> birth_frames() const { return points_.birth_frames; }
  const IncrementalCholesky& factor() const { return factor_; }
  absl::Span<const double> alpha() const { return alpha_; }

  // Means (M3) at N x D points on the context's device in float32; the prior's 0 for an empty
  // model.
  absl::StatusOr<std::vector<float>> PredictMean(kernels::ConstMatrixView<float> points) const;
  // The mean at the model's own points, in float64 and without covariances: y - (sigma_n^2 +
  // jitter) alpha.
  std::vector<double> PredictOwnMean() const;
  // (M3) at N x D points, in float64.
  absl::StatusOr<Prediction> Predict(kernels::ConstMatrixView<double> points,
                                     PredictWhat what) const;

  // log p(y | X) = -1/2 y.alpha - sum_i log L_ii - n/2 log 2 pi; 0 for an empty model.
  double LogMarginalLikelihood() const;

  // Leave-one-out predictions of rows (all where empty).
  absl::StatusOr<LeaveOneOut> PredictLeaveOneOut(absl::Span<const int64_t> rows = {}) const;

  // A posterior that stays as the model is now. Needs no change of the model; costs an upload.
  absl::StatusOr<std::shared_ptr<const Posterior>> MakePosterior(
      const SquashParameters& squash, const kernels::DensePosteriorOptions& options = {}) const;

 private:
  ExactModel() = default;

  // What follows from points and hyperparameters.
  struct Solution {
    IncrementalCholesky factor;
    double jitter = 0.0;
    std::vector<double> alpha;
  };

  absl::Status AppendToFactor(kernels::ConstMatrixView<double> points);
  // The solution for `points` with the first jitter that works: `jitter` itself, or where that was
  // refused already the next rung of the ladder.
  absl::StatusOr<Solution> Solve(const Hyperparameters& hyperparameters, const PointSet& points,
                                 double jitter, bool refused) const;
  // Takes both: cannot fail.
  void Commit(Solution solution, PointSet points);

  std::shared_ptr<kernels::Context> context_;
  Hyperparameters hyperparameters_;
  IncrementalCholesky factor_;
  double jitter_ = 0.0;
  PointSet points_;
  std::vector<double> alpha_;
};

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_MODEL_EXACT_MODEL_H_
