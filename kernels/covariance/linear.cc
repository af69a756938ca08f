// The linear covariance, for functions that are planes through zero (add `constant` for planes
// elsewhere), scales (w_1, ..., w_D):
//
//   f(x, x') = sum_d w_d^2 x_d x'_d,   p_d = w_d x_d,   dv/dlog w_d = 2 p_d p'_d
//
// Float32: (D + 2) u |p| |p'|.
#include <cmath>
#include <memory>

#include "kernels/covariance/elementary.h"

namespace egosieve::kernels {
namespace {

constexpr char kLinearPreparation[] = R"(  for (int d = 0; d < $D; ++d) point[d] = scales[d] * x[d];
)";

constexpr char kLinearCode[] = R"(
static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) {
  REALV sum = (REALV)0;
  UNROLL for (int c = 0; c < $D; ++c) sum = fma(a[c], (REALV)b[c], sum);
  return sum;
}

static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {
  const REALV twice = (REALV)2 * weight;
  UNROLL for (int c = 0; c < $D; ++c) sums[c] = fma(twice, a[c] * b[c], sums[c]);
}

static inline float unit_variance@(__global const float* point, const long stride) {
  float sum = 0.0f;
  for (int c = 0; c < $D; ++c) sum = fma(point[c * stride], point[c * stride], sum);
  return sum;
}
)";

class Linear : public Elementary {
 public:
  Linear()
      : Elementary({{true, ScaleGroup::Unit::kInverseInput, 1.0, std::log(0.05), std::log(20.0)}},
                   kLinearCode, kLinearPreparation) {}

  int64_t PointWidth(int64_t dimension) const override { return dimension; }

  void Prepare(const double* weights, int64_t dimension, const double* x, const double* /*centre*/,
               double* point) const override {
    for (int64_t d = 0; d < dimension; ++d) point[d] = weights[d] * x[d];
  }

  double Value(int64_t dimension, const double* a, const double* b) const override {
    double sum = 0.0;
    for (int64_t d = 0; d < dimension; ++d) sum += a[d] * b[d];
    return sum;
  }

  void AddGradient(int64_t dimension, const double* a, const double* b, double weight,
                   double* gradient) const override {
    for (int64_t d = 0; d < dimension; ++d) gradient[d] += 2.0 * weight * a[d] * b[d];
  }

  void AddInputGradient(const double* weights, int64_t dimension, const double* /*a*/,
                        const double* b, double weight, double* gradient) const override {
    for (int64_t d = 0; d < dimension; ++d) gradient[d] += weight * weights[d] * b[d];
  }

  double Variance(const double* weights, int64_t dimension, const double* x) const override {
    double sum = 0.0;
    for (int64_t d = 0; d < dimension; ++d) sum += weights[d] * x[d] * weights[d] * x[d];
    return sum;
  }
};

const CovarianceRegistration kLinearRegistration("linear", std::make_unique<Linear>());

}  // namespace
}  // namespace egosieve::kernels
