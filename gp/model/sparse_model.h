// Gaussian process regression with m inducing inputs u, for models whose exact posterior is too
// expensive. Two approximations of Quinonero-Candela & Rasmussen (2005), "A unifying view of
// sparse approximate Gaussian process regression":
//
//   v, lambda, A, c                   (SP1) to (SP3) of gp/model/sparse_solution.h
//   mean(x) = v(x).A^-1 c                                                                    (SP4)
//   variance(x) = k(x, x) - |v(x)|^2 + |L_A^-1 v(x)|^2                                       (SP5)
//   log p(y) = -1/2 (sum_i log lambda_i + log|A| + y^T Lambda^-1 y - c.A^-1 c + n log 2 pi)   (SP6)
//
// Adding or removing a point changes one term of (SP3): 2 m^2 flops, and m^3 / 3 for L_A once per
// batch. Memory: that of sparse_solution.h, while the inducing inputs are chosen 8 n m bytes in its
// place. The inducing inputs are chosen anew (n m^2) when a given share of the points or the
// hyperparameters have changed. A is then summed anew, which also removes the rounding errors of
// earlier removals.
//
// A change that fails leaves the model as it was, also if memory is exhausted (std::bad_alloc).
//
// The posteriors evaluate (SP5) as k** - |R k_u|^2 with R^T R = L^-T (I - A^-1) L^-1, R lower
// triangular.
//
// Only one output and the zero mean are supported: points with more outputs are InvalidArgument,
// other mean functions Unimplemented.
//
// Not thread-safe; the posteriors of MakePosterior are.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/calibration/leave_one_out.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/point_set.h"
#include "gp/model/regression_model.h"
#include "gp/model/sample_paths.h"
#include "gp/model/sparse_solution.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

class SparseModel : public RegressionModel {
 public:
  // InvalidArgument for a null context, invalid hyperparameters or options.
  static absl::StatusOr<SparseModel> Create(std::shared_ptr<kernels::Context> context,
                                            const Hyperparameters& hyperparameters,
                                            const SparseModelOptions& options = {});

  // A model from the points and hyperparameters of any model, as after Refresh.
  static absl::StatusOr<SparseModel> Restore(std::shared_ptr<kernels::Context> context,
                                             const ExactModelState& state,
                                             const SparseModelOptions& options = {});

  SparseModel(SparseModel&&) = default;
  SparseModel& operator=(SparseModel&&) = default;

  // As ExactModel's, including errors.
  absl::Status AddObservations(const Observations& added, int64_t time) override;
  absl::Status Remove(absl::Span<const int64_t> rows);
  absl::Status SetHyperparameters(const Hyperparameters& hyperparameters);

  // Uses these inducing inputs (m x D) until the next refresh.
  absl::Status SetInducingInputs(kernels::ConstMatrixView<double> inputs);
  // Chooses the inducing inputs and computes all sums anew: the state then depends on the points
  // and hyperparameters alone. If a run calls it when it writes State(), it continues with the same
  // bits as a run that starts from the state.
  absl::Status Refresh();

  int64_t inducing_size() const { return solution_.inducing_size(); }
  // On K_uu's diagonal.
  double jitter() const { return solution_.jitter; }
  const SparseModelOptions& options() const { return options_; }
  kernels::ConstMatrixView<double> inducing_inputs() const {
    return {solution_.inducing_inputs.data(), inducing_size(), input_dimension()};
  }

  // (SP4) at N x D points in float64; 0 for an empty model.
  absl::StatusOr<std::vector<double>> PredictMean(kernels::ConstMatrixView<double> points) const;
  // The mean at the model's own points.
  absl::StatusOr<std::vector<double>> PredictOwnMean() const { return PredictMean(inputs()); }
  // (SP6); 0 for an empty model.
  double LogMarginalLikelihood() const;
  // Leave-one-out predictions of all points under the approximation's own covariance of y, Q +
  // Lambda, inverted by (SP3): 2 n m^2 flops.
  absl::StatusOr<LeaveOneOut> PredictLeaveOneOut() const;

  // Samples as functions, (PS5) of gp/model/sample_paths.h.
  absl::StatusOr<std::shared_ptr<const SamplePaths>> DrawPaths(const PathOptions& options) const;

 private:
  using RegressionModel::RegressionModel;

  // Computed once per solution: m^3 flops.
  absl::StatusOr<PosteriorParts> Parts() const override;

  // Chooses new inducing inputs for `points`, the model's points after `changed` of them were added
  // or removed, if enough have changed. Returns false if not, or if the choice fails.
  bool RefreshIfStale(int64_t changed, PointSet& points);
  // The solution's with sign times the terms of these points.
  absl::StatusOr<SparseSums> SumsWith(kernels::ConstMatrixView<double> v, const double* lambda,
                                      const double* targets, double sign) const;
  // The last step of adding or removing `changed` points.
  void Commit(SparseSums sums, PointSet points, int64_t changed);

  SparseModelOptions options_;
  SparseSolution solution_;
  int64_t changes_ = 0;  // points since the last refresh
};

}  // namespace egosieve::gp
