// The Matern covariances of smoothness 1/2, 3/2 and 5/2 (Rasmussen & Williams, eq. 4.17), scales
// (l_1, ..., l_D). With r = sqrt(2 nu) |(x - x') / l|, p_d = sqrt(2 nu) x_d / l_d and r^2 = sum_d
// q_d:
//
//   nu    f                              dv/dlog l_d
//   1/2   exp(-r)                        exp(-r) q_d / r, 0 where r = 0
//   3/2   (1 + r) exp(-r)                exp(-r) q_d
//   5/2   (1 + r + r^2 / 3) exp(-r)      (1 + r) / 3 exp(-r) q_d
//
// Frequencies: w_d = sqrt(2 nu / u) z_d / l_d, z normal, u the sum of 2 nu squared normal values: a
// multivariate t distribution (Rasmussen & Williams, eq. 4.15).
//
// Float32: u (|p| + |p'|) from rounding the points (scaled_difference.h), since the slope with
// respect to r is at most 1, and 12 u.
//
// Where r^2 overflows f is 0, though infinity times 0 is none: on the host r^2 is at most 1e10.
#include <algorithm>
#include <cmath>
#include <memory>

#include "kernels/covariance/scaled_difference.h"

namespace egosieve::kernels {
namespace {

constexpr char kCodeOneHalf[] = R"(
static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) {
  return exp_of_negative(-sqrt(squared_distance@(a, b)));
}
static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {
  const REALV square = squared_distance@(a, b);
  const REALV slope = weight * k / sqrt(square);
  add_scaled_squares@(a, b, square > (REALV)0 ? slope : (REALV)0, sums);
}
)";

constexpr char kCodeThreeHalves[] = R"(
static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) {
  const REALV r = sqrt(squared_distance@(a, b));
  return scaled_exp_of_negative(-r, (REALV)1 + r);
}
static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {
  add_scaled_squares@(a, b, weight * exp_of_negative(-sqrt(squared_distance@(a, b))), sums);
}
)";

constexpr char kCodeFiveHalves[] = R"(
static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) {
  const REALV square = squared_distance@(a, b);
  const REALV r = sqrt(square);
  return scaled_exp_of_negative(-r, fma(square, (REALV)1 / (REALV)3, (REALV)1 + r));
}
static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {
  const REALV r = sqrt(squared_distance@(a, b));
  add_scaled_squares@(a, b, weight * ((REALV)1 + r) / (REALV)3 * exp_of_negative(-r), sums);
}
)";

class Matern : public ScaledDifference {
 public:
  // twice_nu: 1, 3 or 5.
  Matern(int twice_nu, const char* device_code)
      : ScaledDifference(std::sqrt(static_cast<double>(twice_nu)), device_code),
        twice_nu_(twice_nu) {}

  double Value(int64_t dimension, const double* a, const double* b) const override {
    const double square = std::min(SquaredDistance(dimension, a, b), 1e10), r = std::sqrt(square);
    const double factor = twice_nu_ == 1 ? 1.0 : twice_nu_ == 3 ? 1.0 + r : 1.0 + r + square / 3.0;
    return factor * std::exp(-r);
  }

  double SpectralMass(const double* /*lengths*/, int64_t /*dimension*/) const override {
    return 1.0;
  }
  void AddFrequency(const double* lengths, int64_t dimension, absl::FunctionRef<double()> normal,
                    double* frequency) const override {
    double square = 0.0;
    for (int i = 0; i < twice_nu_; ++i) {
      const double z = normal();
      square += z * z;
    }
    const double factor = std::sqrt(twice_nu_ / square);
    for (int64_t d = 0; d < dimension; ++d) frequency[d] += factor * normal() / lengths[d];
  }

 protected:
  double Slope(int64_t dimension, const double* a, const double* b) const override {
    const double r = std::sqrt(std::min(SquaredDistance(dimension, a, b), 1e10));
    if (r == 0.0) return 0.0;
    const double factor = twice_nu_ == 1 ? 1.0 / r : twice_nu_ == 3 ? 1.0 : (1.0 + r) / 3.0;
    return factor * std::exp(-r);
  }

 private:
  int twice_nu_;
};

const CovarianceRegistration kOneHalf("matern12", std::make_unique<Matern>(1, kCodeOneHalf));
const CovarianceRegistration kThreeHalves("matern32",
                                          std::make_unique<Matern>(3, kCodeThreeHalves));
const CovarianceRegistration kFiveHalves("matern52", std::make_unique<Matern>(5, kCodeFiveHalves));

}  // namespace
}  // namespace egosieve::kernels
