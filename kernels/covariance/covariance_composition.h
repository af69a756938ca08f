// Covariance functions composed of others: sums, products, and functions in which all inputs share
// a scale.
#pragma once

#include <memory>
#include <vector>

#include "kernels/covariance/covariance_function.h"

namespace egosieve::kernels {

using CovariancePart = std::shared_ptr<const CovarianceDescription>;

// At least two parts.
CovariancePart MakeComposition(std::vector<CovariancePart> parts, bool is_sum);
CovariancePart MakeIsotropic(CovariancePart part);

}  // namespace egosieve::kernels
