// The rational quadratic covariance (Rasmussen & Williams, eq. 4.19), scales (alpha, l_1, ...,
// l_D):
//
//   f(x, x') = (1 + s)^-alpha,   s = 1 / (2 alpha) sum_d ((x_d - x'_d) / l_d)^2
//   dv/dlog l_d = 2 alpha q_d f / (1 + s),   dv/dlog alpha = alpha f (s / (1 + s) - log(1 + s))
//
// A point is p_d = x_d / (l_d sqrt(2 alpha)), followed by alpha. Float32: the slope with respect to
// sqrt(s) is at most sqrt(2 alpha) 0.61, so that rounding x / l counts as for the squared
// exponential; and 40 u.
#include <cmath>
#include <memory>

#include "kernels/covariance/scaled_difference.h"

namespace egosieve::kernels {
namespace {

constexpr char kRationalQuadraticPreparation[] = R"(  const double divisor = sqrt(2.0 * scales[0]);
  for (int d = 0; d < $D; ++d) point[d] /= divisor;
  point[$D] = scales[0];
)";

constexpr char kRationalQuadraticCode[] = R"(
static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) {
  return exp_of_negative(-a[$D] * log1p(squared_distance@(a, b)));
}

static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {
  const REALV square = squared_distance@(a, b);
  const REALV part = weight * k * a[$D];
  sums[0] += part * (square / ((REALV)1 + square) - log1p(square));
  add_scaled_squares@(a, b, (REALV)2 * part / ((REALV)1 + square), sums + 1);
}
)";

class RationalQuadratic : public ScaledDifference {
 public:
  RationalQuadratic()
      : ScaledDifference(1.0, kRationalQuadraticCode,
                         {{false, ScaleGroup::Unit::kNone, 1.0, std::log(0.05), std::log(100.0)},
                          LengthScales()},
                         1, kRationalQuadraticPreparation) {}

  int64_t PointWidth(int64_t dimension) const override { return dimension + 1; }

  void Prepare(const double* scales, int64_t dimension, const double* x, const double* centre,
               double* point) const override {
    ScaledDifference::Prepare(scales + 1, dimension, x, centre, point);
    const double divisor = std::sqrt(2.0 * scales[0]);
    for (int64_t d = 0; d < dimension; ++d) point[d] /= divisor;
    point[dimension] = scales[0];
  }

  double Value(int64_t dimension, const double* a, const double* b) const override {
    return std::exp(-a[dimension] * std::log1p(SquaredDistance(dimension, a, b)));
  }

  void AddGradient(int64_t dimension, const double* a, const double* b, double weight,
                   double* gradient) const override {
    const double square = SquaredDistance(dimension, a, b);
    const double part = weight * a[dimension] * Value(dimension, a, b);
    gradient[0] += part * (square / (1.0 + square) - std::log1p(square));
    ScaledDifference::AddGradient(dimension, a, b, weight, gradient + 1);
  }

  void AddInputGradient(const double* scales, int64_t dimension, const double* a, const double* b,
                        double weight, double* gradient) const override {
    // p_d = x_d / (l_d sqrt(2 alpha)).
    ScaledDifference::AddInputGradient(scales + 1, dimension, a, b,
                                       weight / std::sqrt(2.0 * scales[0]), gradient);
  }

 protected:
  double Slope(int64_t dimension, const double* a, const double* b) const override {
    return 2.0 * a[dimension] * Value(dimension, a, b) / (1.0 + SquaredDistance(dimension, a, b));
  }
};

const CovarianceRegistration kRationalQuadraticRegistration("rational_quadratic",
                                                            std::make_unique<RationalQuadratic>());

}  // namespace
}  // namespace egosieve::kernels
