// Covariance functions composed of others: sums, products, functions in which all inputs share a
// scale, and functions of some of the inputs.
#pragma once

#include <memory>
#include <vector>

#include "kernels/covariance/covariance_function.h"

namespace egosieve::kernels {

using CovariancePart = std::shared_ptr<const CovarianceDescription>;

// At least two parts.
CovariancePart MakeComposition(std::vector<CovariancePart> parts, bool is_sum);
// Of a part without columns.
CovariancePart MakeIsotropic(CovariancePart part);
// Of a part without columns. columns: at least one, increasing, in [0, kMaxInputDimension).
CovariancePart MakeOfColumns(const CovariancePart& part, const std::vector<int64_t>& columns);

}  // namespace egosieve::kernels
