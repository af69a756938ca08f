// The squared exponential (Gaussian) covariance (Rasmussen & Williams, eq. 4.9):
//
//   f(x, x') = exp(-1/2 sum_d ((x_d - x'_d) / l_d)^2),        scales (l_1, ..., l_D)
//   dv/dlog l_d = f q_d,   q_d = ((x_d - x'_d) / l_d)^2
//
// Frequencies: w_d = z_d / l_d, z normal.
//
// Float32: 0.61 u (|p| + |p'|) from rounding the points (scaled_difference.h), and 10 u.
#include <cmath>
#include <memory>

#include "kernels/covariance/scaled_difference.h"

namespace egosieve::kernels {
namespace {

constexpr char kSquaredExponentialCode[] = R"(
static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) {
  return exp_of_negative(squared_distance@(a, b) * (REALV)-0.5f);
}

static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {
  add_scaled_squares@(a, b, weight * k, sums);
}
)";

class SquaredExponential : public ScaledDifference {
 public:
  SquaredExponential() : ScaledDifference(1.0, kSquaredExponentialCode) {}

  double Value(int64_t dimension, const double* a, const double* b) const override {
    return std::exp(-0.5 * SquaredDistance(dimension, a, b));
  }

  double SpectralMass(const double* /*lengths*/, int64_t /*dimension*/) const override {
    return 1.0;
  }
  void AddFrequency(const double* lengths, int64_t dimension, absl::FunctionRef<double()> normal,
                    double* frequency) const override {
    for (int64_t d = 0; d < dimension; ++d) frequency[d] += normal() / lengths[d];
  }

 protected:
  double Slope(int64_t dimension, const double* a, const double* b) const override {
    return Value(dimension, a, b);
  }
};

const CovarianceRegistration kSquaredExponentialRegistration(
    "squared_exponential", std::make_unique<SquaredExponential>());

}  // namespace
}  // namespace egosieve::kernels
