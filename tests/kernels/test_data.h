// Seeded points, factors and guarded arrays for the tests of the kernels.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/posterior_model.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// Seeded by the running test's full name, so that every test has its own numbers and keeps them.
std::mt19937_64 TestRandom();

double Uniform(std::mt19937_64& random, double low, double high);

// A matrix of T between canaries, with `extra` elements of padding at the end of each row.
template <typename T>
class GuardedMatrix {
 public:
  static constexpr T kCanary = T(-12345.5);
  GuardedMatrix(int64_t rows, int64_t cols, int64_t extra = 0)
      : rows_(rows),
        cols_(cols),
        stride_(cols + extra),
        values_(rows * stride_ + 2 * kGuard, kCanary) {}

  MatrixView<T> view() { return {values_.data() + kGuard, rows_, cols_, stride_}; }
  T operator()(int64_t i, int64_t j) const { return values_[kGuard + i * stride_ + j]; }
  T* data() { return values_.data() + kGuard; }
  // No element outside the rows x cols has changed.
  bool guards_intact() const {
    for (size_t k = 0; k < values_.size(); ++k) {
      const int64_t i = static_cast<int64_t>(k) - kGuard;
      const bool inside = i >= 0 && i < rows_ * stride_ && i % stride_ < cols_;
      if (!inside && values_[k] != kCanary) return false;
    }
    return true;
  }
  // Not even the inside.
  bool untouched() const {
    for (const T value : values_) {
      if (value != kCanary) return false;
    }
    return true;
  }

 private:
  static constexpr int64_t kGuard = 67;
  int64_t rows_, cols_, stride_;
  std::vector<T> values_;
};

// n points of D values in [-1, 1], row-major.
std::vector<double> RandomPoints(std::mt19937_64& random, int64_t n, int64_t dimension);

CovarianceParameters ArcsineParameters(std::vector<double> weights, double signal_stddev = 1.0);
CovarianceParameters SquaredExponentialParameters(std::vector<double> lengths,
                                                  double signal_stddev = 1.0);

// k(x, z) in long double from the definition (the difference form for the arcsine).
long double ExactCovariance(const CovarianceParameters& parameters, const double* x,
                            const double* z);

// A regression problem with its Cholesky factor and alpha, computed in float64.
struct Problem {
  CovarianceParameters covariance;
  int64_t count = 0;
  std::vector<double> inputs;
  std::vector<double> alpha;
  std::vector<double> cholesky;  // n x n, lower
  std::vector<double> inverse;   // of cholesky
  PosteriorModel model(FactorKind kind) const;
};

Problem MakeProblem(std::mt19937_64& random, const CovarianceParameters& covariance, int64_t n,
                    double noise_stddev);

// Bounds of a float32 posterior's errors against float64, u = 2^-24 the unit roundoff, k the
// covariances over sigma_f^2, each within 1e-6.
//
//   mean:         sigma_f^2 |alpha|_1 (1e-6 + (64 + n/64 + 2) u pi/2) + 1e-6: rounding of the
//                 blocked sum, and of the result
//   variance:     v = L^-1 k*: |dv| <= |L^-1| |dk| + c u cond(L) |v|;
//                 2 |v| |dv| + (n/96 + 96) u |v|^2, the latter for the blocked sum of squares.
//                 |v|^2 <= k** sigma_f^2, |L^-1|_2 = 1 / noise_stddev,
//                 |dk|_2 <= 1e-6 sigma_f^2 sqrt(n)
//   probability:  its slope is at most phi(0) a by the mean and phi(1) a^2 / 2 by the variance
//
// The second is taken with cond(L) <= sqrt((n pi/2 sigma_f^2 + noise) / noise) and c = 8.
struct PosteriorErrorBounds {
  double mean;
  double variance;
  double probability;
};
PosteriorErrorBounds ErrorBounds(const PosteriorModel& model, double noise_stddev);

// The device of EGOSIEVE_DEVICE or the default one, opened once.
std::shared_ptr<Context> TestContext();

bool TestIsOnReference();

// The same device, asked to compute as GPUs do: scalar work-items side by side in groups, and
// arrays copied to memory of its own.
std::shared_ptr<Context> SideBySideContext();

}  // namespace egosieve::kernels
