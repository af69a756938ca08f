#include "kernels/base/posterior_model.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::kernels {
namespace {

absl::Status CheckFactor(const PosteriorModel& model) {
  const int64_t n = model.inputs.rows;
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("factor", model.factor, n, n));
  for (int64_t i = 0; i < n; ++i) {
    EGOSIEVE_RETURN_IF_ERROR(
        CheckFinite<double>(absl::StrFormat("factor, lower triangle, row %d:", i),
                            ConstMatrixView<double>(model.factor.row(i), 1, i + 1)));
    EGOSIEVE_REQUIRE(
        InvalidArgument, model.factor_kind != FactorKind::kCholesky || model.factor(i, i) > 0.0,
        "factor(%d, %d) = %g; a Cholesky factor's diagonal is positive", i, i, model.factor(i, i));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status PosteriorModel::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(covariance.Validate());
  const int64_t n = inputs.rows;
  if (n > 0) {
    EGOSIEVE_RETURN_IF_ERROR(CheckShape("inputs", inputs, n, covariance.input_dimension()));
    EGOSIEVE_RETURN_IF_ERROR(CheckFinite("inputs", inputs));
    EGOSIEVE_RETURN_IF_ERROR(CheckShape("alpha", alpha, n, 1, 1, n, 1));
    EGOSIEVE_RETURN_IF_ERROR(CheckFinite("alpha", ConstMatrixView<double>(alpha, n, 1)));
  }
  EGOSIEVE_REQUIRE(InvalidArgument, std::isfinite(squash_a) && std::isfinite(squash_b),
                   "squash_a = %g, squash_b = %g; both must be finite", squash_a, squash_b);
  return factor_kind == FactorKind::kNone || n == 0 ? absl::OkStatus() : CheckFactor(*this);
}

}  // namespace egosieve::kernels
