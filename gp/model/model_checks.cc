#include "gp/model/model_checks.h"

#include "absl/strings/str_format.h"
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

absl::Status CheckAddition(const Observations& added, const PointSet& points, int64_t dimension) {
  EGOSIEVE_RETURN_IF_ERROR(added.Validate(dimension));
  if (added.size() > 0 && points.size() > 0 && added.outputs() != points.outputs) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "targets of %d outputs; the model's points have %d", added.outputs(), points.outputs));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::gp
