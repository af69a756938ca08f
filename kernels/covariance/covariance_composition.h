// Covariance functions composed of others: sums, products, and functions in which all inputs share
// a scale.
#ifndef EGOSIEVE_KERNELS_COVARIANCE_COVARIANCE_COMPOSITION_H_
#define EGOSIEVE_KERNELS_COVARIANCE_COVARIANCE_COMPOSITION_H_

#include <memory>
#include <vector>

#include "kernels/covariance/covariance_function.h"

namespace egosieve::kernels {

using CovariancePart = std::shared_ptr<const CovarianceDescription>;

// At least two parts.
CovariancePart MakeComposition(std::vector<CovariancePart> parts, bool is_sum);
CovariancePart MakeIsotropic(CovariancePart part);

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_COVARIANCE_COVARIANCE_COMPOSITION_H_
