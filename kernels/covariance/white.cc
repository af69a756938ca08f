// White noise as part of the function, f(x, x') = 1 if x = x', else 0; no scales. Unlike the noise
// of the observations, it is the same for all observations of one point, and predictions of f
// contain it.
//
// Prepared points are compared: in float32, two points that differ by less than a rounding are
// equal.
#include <algorithm>
#include <memory>

#include "absl/strings/str_cat.h"
#include "kernels/covariance/elementary.h"

namespace egosieve::kernels {
namespace {

constexpr char kWhitePreparation[] = R"(  for (int d = 0; d < $D; ++d) point[d] = x[d] - centre[d];
)";

constexpr char kWhiteCode[] = R"(
static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) {
  REALV distance = (REALV)0;
  UNROLL for (int c = 0; c < $D; ++c) distance = fmax(distance, fabs(a[c] - b[c]));
  return distance == (REALV)0 ? (REALV)1 : (REALV)0;
}
static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {}
)";

class White : public Scaleless {
 public:
  White() : Scaleless(absl::StrCat(kUnitVarianceCode, kWhiteCode), kWhitePreparation) {}

  int64_t PointWidth(int64_t dimension) const override { return dimension; }
  void Prepare(const double* /*scales*/, int64_t dimension, const double* x, const double* centre,
               double* point) const override {
    for (int64_t d = 0; d < dimension; ++d) point[d] = x[d] - centre[d];
  }
  double Value(int64_t dimension, const double* a, const double* b) const override {
    return std::equal(a, a + dimension, b) ? 1.0 : 0.0;
  }
};

const CovarianceRegistration kWhiteRegistration("white", std::make_unique<White>());

}  // namespace
}  // namespace egosieve::kernels
