// Common parts of functions of the scaled distance.
//
//   p_d(x) = m (x_d - c_d) / l_d,   q_d = (p_d - p'_d)^2,   s = sum_d q_d;  scales (l_1, ..., l_D)
//
// In float32 a difference of points has an error of u (|p| + |p'|), u = 2^-24, in norm. So has f if
// its slope with respect to sqrt(s) is at most 1.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/covariance/elementary.h"

namespace egosieve::kernels {

// Device code of s for $D components.
inline constexpr char kSquaredDistanceCode[] = R"(
static inline REALV squared_distance@(const REALV* a, POINT_SPACE const REAL* b) {
  REALV square = (REALV)0;
  UNROLL for (int c = 0; c < $D; ++c) {
    const REALV difference = a[c] - b[c];
    square = fma(difference, difference, square);
  }
  return square;
}
)";

// Device code of sums[d] += factor q_d.
inline constexpr char kAddSquaresCode[] = R"(
static inline void add_scaled_squares@(const REALV* a, POINT_SPACE const REAL* b, const REALV factor, REALV* sums) {
  UNROLL for (int c = 0; c < $D; ++c) {
    const REALV difference = a[c] - b[c];
    sums[c] = fma(factor, difference * difference, sums[c]);
  }
}
)";

// Device code of point[d] = factor (x_d - c_d) / lengths[d].
inline constexpr char kScaleDifferencesCode[] = R"(
static inline void scale_differences@(const double* lengths, const double* x, const double* centre, const double factor,
                                      double* point) {
  for (int d = 0; d < $D; ++d) point[d] = factor * ((x[d] - centre[d]) / lengths[d]);
}
)";

// s.
inline double SquaredDistance(int64_t components, const double* a, const double* b) {
  double sum = 0.0;
  for (int64_t c = 0; c < components; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

// gradient[d] -= factor (p_d - p'_d) / l_d.
inline void AddDifferences(int64_t dimension, const double* a, const double* b, double factor,
                           const double* lengths, double* gradient) {
  for (int64_t d = 0; d < dimension; ++d) gradient[d] -= factor * (a[d] - b[d]) / lengths[d];
}

// gradient[d] += factor q_d.
inline void AddSquares(int64_t components, const double* a, const double* b, double factor,
                       double* gradient) {
  for (int64_t c = 0; c < components; ++c) gradient[c] += factor * (a[c] - b[c]) * (a[c] - b[c]);
}

// Functions of s; the first D values of a prepared point are p. With a = p(x), b = p(x') and the
// factor g of dv / dlog l_d = g q_d, df(x, x') / dx_d = -g m (p_d - p'_d) / l_d.
class ScaledDifference : public Elementary {
 public:
  int64_t PointWidth(int64_t dimension) const override { return dimension; }

  void Prepare(const double* lengths, int64_t dimension, const double* x, const double* centre,
               double* point) const override {
    for (int64_t d = 0; d < dimension; ++d) {
      point[d] = multiplier_ * ((x[d] - centre[d]) / lengths[d]);
    }
  }

  // For functions whose only scales are the lengths.
  void AddGradient(int64_t dimension, const double* a, const double* b, double weight,
                   double* gradient) const override {
    AddSquares(dimension, a, b, weight * Slope(dimension, a, b), gradient);
  }
  void AddInputGradient(const double* lengths, int64_t dimension, const double* a, const double* b,
                        double weight, double* gradient) const override {
    AddDifferences(dimension, a, b, weight * Slope(dimension, a, b) * multiplier_, lengths,
                   gradient);
  }

 protected:
  // g.
  virtual double Slope(int64_t dimension, const double* a, const double* b) const = 0;

  // own_code: what follows the functions above; preparation: what follows scale_differences of the
  // scales from `first_length` on.
  ScaledDifference(double multiplier, const char* own_code,
                   std::vector<ScaleGroup> groups = {LengthScales()}, int first_length = 0,
                   const char* preparation = "")
      : Elementary(
            std::move(groups),
            absl::StrCat(kSquaredDistanceCode, kAddSquaresCode, kUnitVarianceCode, own_code),
            absl::StrFormat("  scale_differences@(scales + %d, x, centre, %.17g, point);\n%s",
                            first_length, multiplier, preparation),
            kScaleDifferencesCode),
        multiplier_(multiplier) {}

 private:
  double multiplier_;  // m
};

}  // namespace egosieve::kernels
