// The arcsine (neural network) covariance (paper, eq. 5; Rasmussen & Williams eq. 4.29 has a factor
// 2/pi in front, GPML's covNNone is the same with 2 Sigma = I / ell^2):
//
//   f(x, x') = asin( a.b / sqrt((1 + a.a)(1 + b.b)) ),
//   a = sqrt(2) diag(w) (1, x),  b = sqrt(2) diag(w) (1, x'),      scales (w_0, w_1, ..., w_D)
//
// Points are normalised once in float64:
//
//   (1) a^ = a / sqrt(1 + a.a),   e = 1 / (1 + a.a),   so that  a^.a^ + e = 1
//
// With z = a^.b^, s = sign z and |a^|^2 = 1 - e_a, |b^|^2 = 1 - e_b:
//
//   (2) |a^ - s b^|^2 = 2 - e_a - e_b - 2 |z|,  hence
//       h = (1 - |z|) / 2 = (|a^ - s b^|^2 + e_a + e_b) / 4
//   (3) asin z = s (pi/2 - 2 asin sqrt(h)),  0 <= h <= 1/2
//
// Nothing cancels in (2), since the sum has no negative term. Rounding a^ and b^ to a unit roundoff
// u changes a^ - s b^ by at most u (|a^| + |b^|) <= 2u in norm, so the error of sqrt(h) is at most
// u. The derivative of asin z with respect to sqrt(h) is at most 2 / sqrt(1 - h) <= 2.83, so the
// error of asin z is at most 2.83 u plus the rounding of the sum and of the polynomial. A point is
// stored as (a^ / 2, e / 4): then h is a plain sum of squares. In float32 the error is at most 1e-6
// for all inputs.
//
//   dv/dlog w_d = s (2 h (a^_d^2 + b^_d^2) - (a^_d - s b^_d)^2) / sqrt(1 - z^2),
//   1 - z^2 = 4 h (1 - h)
#include "kernels/covariance/arcsine.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "kernels/covariance/elementary.h"

namespace egosieve::kernels {

double DifferenceThreshold(int64_t components) {
  const int64_t roundings = (components + 1) / 2 + 3;  // in the longer of the two chains
  const double s = static_cast<double>(roundings) * std::ldexp(1.0, -24) / 1.7e-6;
  return s < 0.5 ? 0.5 - std::sqrt(0.25 - s * s) : 1.0;
}

namespace {

constexpr double kHalfPi = 1.57079632679489661923;

// Keeps h positive in float32 for weights so large that e would underflow; it changes sqrt(h) by at
// most 1e-15.
constexpr double kSmallestQuarter = 1e-30;

// $C: number of components. $B: the h below which the dot product's rounding exceeds 1e-6
// (arcsine.h); there h comes from the difference of vectors, lane by lane. $PLAIN: no lane can be
// below.
constexpr char kArcsinePreparation[] = R"(  double half_norm = scales[0] * scales[0];
  for (int d = 0; d < $D; ++d) {
    const double a = scales[d + 1] * x[d];
    half_norm += a * a;
  }
  const double e = 1.0 / (1.0 + 2.0 * half_norm);
  const double factor = sqrt(0.5 * e);
  point[0] = factor * scales[0];
  for (int d = 0; d < $D; ++d) point[d + 1] = factor * (scales[d + 1] * x[d]);
  point[$D + 1] = fmax(0.25 * e, $SMALLEST);
)";

constexpr char kArcsineCode[] = R"(
// 4 times this is z. Two chains: half the latency and half the rounding of one.
static inline REALV half_vectors_dot@(const REALV* a, POINT_SPACE const REAL* b) {
  REALV even = a[0] * b[0];
  REALV odd = a[1] * b[1];
  UNROLL for (int c = 2; c < $C; c += 2) even = fma(a[c], (REALV)b[c], even);
  UNROLL for (int c = 3; c < $C; c += 2) odd = fma(a[c], (REALV)b[c], odd);
  return even + odd;
}

// h by equation (2), for s = the sign of `dot`.
static inline REALV half_of_difference@(const REALV* a, POINT_SPACE const REAL* b, REALV dot) {
  const REALV sign = with_sign((REALV)1, dot);
  REALV square = a[$C] + b[$C];
  UNROLL for (int c = 0; c < $C; ++c) {
    const REALV difference = fma(-sign, (REALV)b[c], a[c]);
    square = fma(difference, difference, square);
  }
  return square;
}

static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) {
  const REALV dot = half_vectors_dot@(a, b);
#ifdef REAL_IS_DOUBLE
  const REALV h = half_of_difference@(a, b, dot);
#else
  REALV h = fma(fabs(dot), (REALV)-2, (REALV)0.5f);
#if !$PLAIN
  if (any_below(h, $Bf)) {
    const REALV accurate = half_of_difference@(a, b, dot);
    h = h < (REALV)$Bf ? accurate : h;
  }
#endif
#endif
  return with_sign(arccosine_of_half(h), dot);
}

static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {
  const REALV dot = half_vectors_dot@(a, b);
  const REALV h = half_of_difference@(a, b, dot);
  const REALV sign = with_sign((REALV)1, dot);
  const REALV signed_weight = weight * sign;
  // The stored components are halves: 4 (a/2)^2 = a^2.
  const REALV factor = signed_weight * (REALV)2 / sqrt(h * ((REALV)1 - h));
  const REALV twice_h = h * (REALV)2;
  UNROLL for (int c = 0; c < $C; ++c) {
    const REALV difference = fma(-sign, (REALV)b[c], a[c]);
    const REALV squares = fma(a[c], a[c], (REALV)(b[c] * b[c]));
    sums[c] = fma(factor, fma(twice_h, squares, -difference * difference), sums[c]);
  }
}

// pi/2 - 2 asin sqrt(e / 2), from e / 4 as it is stored.
static inline float unit_variance@(__global const float* point, const long stride) {
  return 1.57079632679489661923f - 2.0f * asin(sqrt(2.0f * point[$C * stride]));
}
)";

class Arcsine : public Elementary {
 public:
  Arcsine()
      : Elementary(
            {{false, ScaleGroup::Unit::kNone, std::exp(0.5 * 1.4), 0.5 * -5.0, 0.5 * 7.0},
             {true, ScaleGroup::Unit::kInverseInput, std::exp(0.5 * 1.4), 0.5 * -5.0, 0.5 * 7.0}},
            kArcsineCode,
            absl::StrReplaceAll(kArcsinePreparation,
                                {{"$SMALLEST", absl::StrFormat("%.17g", kSmallestQuarter)}})) {}

  int64_t PointWidth(int64_t dimension) const override { return dimension + 2; }

  void Prepare(const double* w, int64_t dimension, const double* x, const double* /*centre*/,
               double* point) const override {
    const int64_t components = dimension + 1;
    double half_norm = w[0] * w[0];  // a.a / 2
    for (int64_t d = 1; d < components; ++d) {
      const double a = w[d] * x[d - 1];
      half_norm += a * a;
    }
    const double e = 1.0 / (1.0 + 2.0 * half_norm);
    const double factor = std::sqrt(0.5 * e);  // sqrt(2) / (2 sqrt(1 + a.a))
    point[0] = factor * w[0];
    for (int64_t d = 1; d < components; ++d) point[d] = factor * (w[d] * x[d - 1]);
    point[components] = std::max(0.25 * e, kSmallestQuarter);
  }

  double Value(int64_t dimension, const double* a, const double* b) const override {
    const Terms terms = TermsOf(dimension + 1, a, b);
    return terms.sign * (kHalfPi - 2.0 * std::asin(std::sqrt(terms.h)));
  }

  void AddGradient(int64_t dimension, const double* a, const double* b, double weight,
                   double* gradient) const override {
    const auto [sign, h] = TermsOf(dimension + 1, a, b);
    // The stored components are halves: 4 (a/2)^2 = a^2.
    const double factor = weight * sign * 4.0 / (2.0 * std::sqrt(h * (1.0 - h)));
    for (int64_t c = 0; c <= dimension; ++c) {
      const double difference = a[c] - sign * b[c];
      gradient[c] += factor * (2.0 * h * (a[c] * a[c] + b[c] * b[c]) - difference * difference);
    }
  }

  // With a^ = 2 a, b^ = 2 b and z = a^.b^: dz / dx_d = sqrt(2 e_a) w_d (b^_d - z a^_d), and
  // dasin z = dz / sqrt(1 - z^2), 1 - z^2 = 4 h (1 - h).
  void AddInputGradient(const double* w, int64_t dimension, const double* a, const double* b,
                        double weight, double* gradient) const override {
    const auto [sign, h] = TermsOf(dimension + 1, a, b);
    const double z = sign * (1.0 - 2.0 * h), e = 4.0 * a[dimension + 1];
    const double factor = weight * std::sqrt(2.0 * e) / (2.0 * std::sqrt(h * (1.0 - h)));
    for (int64_t d = 1; d <= dimension; ++d) {
      gradient[d - 1] += factor * w[d] * 2.0 * (b[d] - z * a[d]);
    }
  }

  double Variance(const double* w, int64_t dimension, const double* x) const override {
    double sum = w[0] * w[0];
    for (int64_t d = 1; d <= dimension; ++d) sum += w[d] * w[d] * x[d - 1] * x[d - 1];
    // asin(z) = atan(z / sqrt(1 - z^2)); with z = s / (1 + s), 1 - z^2 = (1 + 2 s) / (1 + s)^2: no
    // cancellation for z near 1.
    const double s = 2.0 * sum;
    return std::atan(s / std::sqrt(1.0 + 2.0 * s));
  }

  std::string DeviceCode(const DeviceCodeRequest& request) const override {
    const int64_t components = request.dimension + 1;
    return absl::StrReplaceAll(Elementary::DeviceCode(request),
                               {{"$C", absl::StrCat(components)},
                                {"$B", absl::StrFormat("%.9f", DifferenceThreshold(components))},
                                {"$PLAIN", DotSuffices(request) ? "1" : "0"}});
  }

 private:
  struct Terms {
    double sign;  // s
    double h;     // (1 - |z|) / 2
  };

  static Terms TermsOf(int64_t components, const double* a, const double* b) {
    double dot = 0.0;
    for (int64_t c = 0; c < components; ++c) dot += a[c] * b[c];
    const double sign = dot < 0.0 ? -1.0 : 1.0;
    double h = a[components] + b[components];
    for (int64_t c = 0; c < components; ++c) {
      const double difference = a[c] - sign * b[c];
      h += difference * difference;
    }
    return {sign, std::min(h, 0.5)};
  }

  // |z| <= |a^| = sqrt(1 - e_a) for every query, so h >= (1 - sqrt(1 - e_a)) / 2 >= e_a / 4, and
  // the prepared training inputs contain e_a / 4.
  static bool DotSuffices(const DeviceCodeRequest& request) {
    float smallest = request.points.rows == 0 ? 0.0f : 1.0f;
    for (int64_t i = 0; i < request.points.rows; ++i) {
      smallest = std::min(smallest, request.points(i, request.dimension + 1));
    }
    return smallest > DifferenceThreshold(request.dimension + 1);
  }
};

const CovarianceRegistration kArcsineRegistration("arcsine", std::make_unique<Arcsine>());

}  // namespace
}  // namespace egosieve::kernels
