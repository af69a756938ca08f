// Robust noise scale of the static majority, from residuals that include movers.
//
//   sigma_0 = median r / q_d                       q_1 = 0.6745, q_2 = 1.1774 (Rayleigh)      (SC1)
//   sigma_(k+1)^2 = mean{ r^2 : r < 2.5 sigma_k } / (d c_d)                                   (SC2)
//
// d is the number of components in r (1: a distance to a line, 2: to a point), c_d the share of the
// variance that remains after the cut: c_1 = 0.9112, c_2 = 0.8564. (SC2) removes most of the effect
// of movers on the median. The cost is linear.
#pragma once

#include <vector>

namespace egosieve::vision {

// residuals: of any sign; non-finite ones are ignored. The result is at least `floor`, and `floor`
// without residuals. dimensions: d, 1 or 2.
double ResidualScale(std::vector<double> residuals, int dimensions, double floor);

}  // namespace egosieve::vision
