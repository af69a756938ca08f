#include "gp/model/regression_model.h"

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

absl::StatusOr<std::shared_ptr<const Float64Posterior>> RegressionModel::MakeFloat64Posterior()
    const {
  EGOSIEVE_ASSIGN_OR_RETURN(PosteriorParts parts, Parts());
  EGOSIEVE_RETURN_IF_ERROR(parts.weights->CheckDetermined());
  return std::make_shared<const Float64Posterior>(context_, hyperparameters_, parts.inputs,
                                                  *parts.weights, std::move(parts.factor));
}

}  // namespace egosieve::gp
