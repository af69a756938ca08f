#include "gp/model/regression_model.h"

#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {

using kernels::ConstMatrixView;

absl::Status ExactModelState::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(hyperparameters.Validate());
  return points.Validate(hyperparameters.covariance.input_dimension());
}

absl::Status RegressionModel::Add(ConstMatrixView<double> inputs, absl::Span<const double> labels,
                                  int64_t time) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> targets, TargetsOfLabels(labels));  // (RM1)
  return AddObservations({inputs, targets}, time);
}

absl::StatusOr<std::shared_ptr<const Posterior>> RegressionModel::MakePosterior(
    const SquashParameters& squash, const kernels::DensePosteriorOptions& options,
    const kernels::Contexts& devices) const {
  EGOSIEVE_ASSIGN_OR_RETURN(const PosteriorParts parts, Parts());
  return Posterior::Create(devices.empty() ? kernels::Contexts{context_} : devices,
                           hyperparameters_, parts.inputs, *parts.weights, parts.factor, squash,
                           options);
}

absl::Status CheckSetUp(const kernels::Context* context, const Hyperparameters& hyperparameters) {
  EGOSIEVE_REQUIRE(InvalidArgument, context != nullptr,
                   "context is null; open one with OpenContext");
  return hyperparameters.Validate();
}

absl::Status CheckZeroMean(const char* kind, const Hyperparameters& hyperparameters) {
  EGOSIEVE_REQUIRE(Unimplemented, hyperparameters.mean == MeanFunction::kZero,
                   "%s models have the zero mean; take the mean off the targets", kind);
  return absl::OkStatus();
}

absl::Status CheckReplacement(const Hyperparameters& hyperparameters, int64_t size,
                              int64_t dimension) {
  EGOSIEVE_RETURN_IF_ERROR(hyperparameters.Validate());
  const int64_t wanted = hyperparameters.covariance.input_dimension();
  EGOSIEVE_REQUIRE(InvalidArgument, size == 0 || wanted == dimension,
                   "the covariance takes %d inputs; the model's points have %d", wanted, dimension);
  return absl::OkStatus();
}

absl::Status CheckAddition(const Observations& added, const PointSet& points, int64_t dimension) {
  EGOSIEVE_RETURN_IF_ERROR(added.Validate(dimension));
  EGOSIEVE_REQUIRE(
      InvalidArgument, added.size() == 0 || points.size() == 0 || added.outputs() == points.outputs,
      "targets of %d outputs; the model's points have %d", added.outputs(), points.outputs);
  return absl::OkStatus();
}

absl::Status ReplaceTargets(kernels::ConstMatrixView<double> targets, int64_t dimension,
                            PointSet& points) {
  EGOSIEVE_REQUIRE(
      InvalidArgument,
      targets.rows == points.size() && (targets.rows == 0 || targets.cols == points.outputs),
      "%d targets of %d outputs; the model has %d points of %d outputs", targets.rows, targets.cols,
      points.size(), points.outputs);
  EGOSIEVE_RETURN_IF_ERROR(
      Observations(points.view(dimension), targets, points.noise_variances).Validate(dimension));
  for (int64_t i = 0; i < targets.rows; ++i) {
    for (int64_t k = 0; k < targets.cols; ++k) points.targets[i * targets.cols + k] = targets(i, k);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const Float64Posterior>> RegressionModel::MakeFloat64Posterior()
    const {
  EGOSIEVE_ASSIGN_OR_RETURN(PosteriorParts parts, Parts());
  EGOSIEVE_RETURN_IF_ERROR(parts.weights->CheckDetermined());
  return std::make_shared<const Float64Posterior>(context_, hyperparameters_, parts.inputs,
                                                  *parts.weights, std::move(parts.factor));
}

}  // namespace egosieve::gp
