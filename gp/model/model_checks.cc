#include "gp/model/model_checks.h"

#include "absl/strings/str_format.h"
#include "gp/model/point_set.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {

absl::Status CheckSetUp(const kernels::Context* context, const Hyperparameters& hyperparameters) {
  if (context == nullptr) {
    return absl::InvalidArgumentError("context is null; open one with OpenContext");
  }
  return hyperparameters.Validate();
}

absl::Status CheckReplacement(const Hyperparameters& hyperparameters, int64_t size,
                              int64_t dimension) {
  EGOSIEVE_RETURN_IF_ERROR(hyperparameters.Validate());
  const int64_t wanted = hyperparameters.covariance.input_dimension();
  if (size > 0 && wanted != dimension) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "the covariance takes %d inputs; the model's points have %d", wanted, dimension));
  }
  return absl::OkStatus();
}

absl::Status CheckAddition(kernels::ConstMatrixView<double> inputs,
                           absl::Span<const double> targets, int64_t dimension) {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(inputs, dimension));
  return CheckTargets(targets, inputs.rows);
}

}  // namespace egosieve::gp
