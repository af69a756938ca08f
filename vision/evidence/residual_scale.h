// The noise of the static majority from residuals with movers among them.
//
//   sigma_0 = median r / q_d                       q_1 = 0.6745, q_2 = 1.1774 (Rayleigh)       (S1)
//   sigma_(k+1)^2 = mean{ r^2 : r < 2.5 sigma_k } / (d c_d)                                    (S2)
//
// d is the number of components in r (1: a distance to a line, 2: to a point), c_d the variance
// left by the cut: c_1 = 0.9112, c_2 = 0.8564. (S2) takes out most of the movers' part in the
// median. Linear cost.
#ifndef EGOSIEVE_VISION_EVIDENCE_RESIDUAL_SCALE_H_
#define EGOSIEVE_VISION_EVIDENCE_RESIDUAL_SCALE_H_

#include <vector>

namespace egosieve::vision {

// residuals: any sign; those that are not finite are left out. At least `floor`; `floor` for none.
// dimensions: 1 or 2.
double ResidualScale(std::vector<double> residuals, int dimensions, double floor);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_RESIDUAL_SCALE_H_
