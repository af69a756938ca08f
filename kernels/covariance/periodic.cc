// The periodic covariance (Rasmussen & Williams, eq. 4.31), scales (l_1, ..., l_D, t_1, ..., t_D):
//
//   f(x, x') = exp(-2 sum_d sin^2(pi (x_d - x'_d) / t_d) / l_d^2)
//
// With the angle h_d = 2 pi x_d / t_d it is the squared exponential of (cos h_d, sin h_d) / l_d,
// since 4 sin^2((h - h') / 2) = (cos h - cos h')^2 + (sin h - sin h')^2. A point consists of
// cosines, sines and angles; the angles serve only the derivatives with respect to the periods:
//
//   dv/dlog l_d = f q_d,   dv/dlog t_d = f (h_d - h'_d) sin(h_d - h'_d) / l_d^2
//
// Float32: 2 u / l_d per input from rounding sines and cosines, for any x; and 10 u.
#include <cmath>
#include <memory>

#include "absl/strings/str_cat.h"
#include "kernels/covariance/scaled_difference.h"

namespace egosieve::kernels {
namespace {

constexpr char kPeriodicPreparation[] = R"(  for (int d = 0; d < $D; ++d) {
    const double angle = 2.0 * M_PI * ((x[d] - centre[d]) / scales[$D + d]);
    point[d] = cos(angle) / scales[d];
    point[$D + d] = sin(angle) / scales[d];
    point[2 * $D + d] = angle;
  }
)";

constexpr char kPeriodicCode[] = R"(
static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) {
  REALV square = (REALV)0;
  UNROLL for (int c = 0; c < 2 * $D; ++c) {
    const REALV difference = a[c] - b[c];
    square = fma(difference, difference, square);
  }
  return exp_of_negative(square * (REALV)-0.5f);
}

static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {
  const REALV factor = weight * k;
  UNROLL for (int d = 0; d < $D; ++d) {
    const REALV cosines = a[d] - b[d];
    const REALV sines = a[d + $D] - b[d + $D];
    sums[d] = fma(factor, fma(cosines, cosines, sines * sines), sums[d]);
    const REALV sine = a[d + $D] * b[d] - a[d] * b[d + $D];
    sums[d + $D] = fma(factor, (a[d + 2 * $D] - b[d + 2 * $D]) * sine, sums[d + $D]);
  }
}
)";

class Periodic : public Elementary {
 public:
  Periodic()
      : Elementary({{true, ScaleGroup::Unit::kNone, 1.0, std::log(0.05), std::log(20.0)},
                    {true, ScaleGroup::Unit::kInput, 1.0, std::log(0.05), std::log(20.0)}},
                   absl::StrCat(kUnitVarianceCode, kPeriodicCode), kPeriodicPreparation) {}

  int64_t PointWidth(int64_t dimension) const override { return 3 * dimension; }

  void Prepare(const double* scales, int64_t dimension, const double* x, const double* centre,
               double* point) const override {
    for (int64_t d = 0; d < dimension; ++d) {
      const double angle = 2.0 * M_PI * ((x[d] - centre[d]) / scales[dimension + d]);
      point[d] = std::cos(angle) / scales[d];
      point[dimension + d] = std::sin(angle) / scales[d];
      point[2 * dimension + d] = angle;
    }
  }

  double Value(int64_t dimension, const double* a, const double* b) const override {
    return std::exp(-0.5 * SquaredDistance(2 * dimension, a, b));
  }

  void AddGradient(int64_t dimension, const double* a, const double* b, double weight,
                   double* gradient) const override {
    const double factor = weight * Value(dimension, a, b);
    AddSquares(dimension, a, b, factor, gradient);
    AddSquares(dimension, a + dimension, b + dimension, factor, gradient);
    for (int64_t d = 0; d < dimension; ++d) {
      const double sine = a[dimension + d] * b[d] - a[d] * b[dimension + d];
      gradient[dimension + d] += factor * (a[2 * dimension + d] - b[2 * dimension + d]) * sine;
    }
  }

  void AddInputGradient(const double* scales, int64_t dimension, const double* a, const double* b,
                        double weight, double* gradient) const override {
    const double factor = 2.0 * M_PI * weight * Value(dimension, a, b);
    for (int64_t d = 0; d < dimension; ++d) {
      const double sine = a[dimension + d] * b[d] - a[d] * b[dimension + d];
      gradient[d] -= factor * sine / scales[dimension + d];
    }
  }
};

const CovarianceRegistration kPeriodicRegistration("periodic", std::make_unique<Periodic>());

}  // namespace
}  // namespace egosieve::kernels
