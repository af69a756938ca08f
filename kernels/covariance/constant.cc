// The constant covariance, f(x, x') = 1, for functions that have the same value everywhere; no
// scales.
#include <memory>

#include "kernels/covariance/elementary.h"

namespace egosieve::kernels {
namespace {

constexpr char kConstantCode[] = R"(
static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) { return (REALV)1; }
static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {}
static inline float unit_variance@(__global const float* point, const long stride) { return 1.0f; }
)";

class Constant : public Scaleless {
 public:
  Constant() : Scaleless(kConstantCode, "") {}

  int64_t PointWidth(int64_t /*dimension*/) const override { return 0; }
  void Prepare(const double* /*scales*/, int64_t /*dimension*/, const double* /*x*/,
               const double* /*centre*/, double* /*point*/) const override {}
  double Value(int64_t /*dimension*/, const double* /*a*/, const double* /*b*/) const override {
    return 1.0;
  }
  double SpectralMass(const double* /*scales*/, int64_t /*dimension*/) const override {
    return 1.0;
  }
};

const CovarianceRegistration kConstantRegistration("constant", std::make_unique<Constant>());

}  // namespace
}  // namespace egosieve::kernels
