// Sums, products, shared scales and columns of covariance functions: descriptions composed of
// descriptions. The grammar is in covariance_function.h.
//
//   sum        p = (p_1, a_2, p_2, ...)   v = v_1 + a_2 a_2' v_2 + ...
//                                         dv/dlog a_2 = 2 a_2 a_2' v_2
//   product    p = (p_1, p_2, ...)        v = v_1 v_2 ...
//   isotropic  p with equal scales within a group; a group's derivatives are summed
//   frequencies (covariance_function.h)   of a sum: one term's, by its share of f(0); of a product:
//              the sum of its factors' frequencies
//   columns    p of (x_c1, x_c2, ...); derivatives by other inputs are 0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/covariance/covariance_function.h"

namespace egosieve::kernels {

using CovariancePart = std::shared_ptr<const CovarianceDescription>;
using CovarianceNames = std::map<std::string, CovariancePart, std::less<>>;

// At least two parts.
CovariancePart MakeComposition(std::vector<CovariancePart> parts, bool is_sum);
// Of a part without columns.
CovariancePart MakeIsotropic(CovariancePart part);
// Of a part without columns. columns: at least one, increasing, in [0, kMaxInputDimension).
CovariancePart MakeOfColumns(const CovariancePart& part, const std::vector<int64_t>& columns);

struct NamedDescription {
  std::string text;  // canonical
  CovariancePart description;
};

// `names`: the elementary functions.
absl::StatusOr<NamedDescription> ParseCovariance(std::string_view text,
                                                 const CovarianceNames& names);

}  // namespace egosieve::kernels
