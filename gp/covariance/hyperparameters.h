// The hyperparameters of the Gaussian process, and their logarithms, in which they are optimised.
//
//   theta = (log s_1, ..., log s_P, log sigma_f, log sigma_n)
//
// s are the covariance's scales (kernels/covariance/covariance_function.h): for the arcsine the
// weights w_0, ..., w_D, P = D + 1; for the squared exponential the length-scales l_1, ..., l_D, P
// = D. All are positive, so the logarithms are unconstrained. Bounds limit those that the data do
// not determine (the weight of an irrelevant input tends to zero).
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/covariance/mean_function.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

struct Hyperparameters {
  kernels::CovarianceParameters covariance;
  double noise_stddev = 0.5;                // sigma_n
  MeanFunction mean = MeanFunction::kZero;  // its coefficients are determined by the data

  double noise_variance() const { return noise_stddev * noise_stddev; }
  // Number of elements of theta: scales.size() + 2.
  int64_t count() const { return static_cast<int64_t>(covariance.scales.size()) + 2; }
  // InvalidArgument, with field and value, unless the covariance is valid and sigma_n finite and
  // positive.
  absl::Status Validate() const;
};

// theta; the hyperparameters must be valid.
std::vector<double> ToLogarithms(const Hyperparameters& hyperparameters);

// The inverse of ToLogarithms, with the covariance function, dimension and mean of `like`.
// InvalidArgument unless theta has as many values as that of `like`, and every exponential is finite
// and positive.
absl::StatusOr<Hyperparameters> FromLogarithms(const Hyperparameters& like,
                                               absl::Span<const double> theta);

// Initial values for inputs in [-1, 1]^D: the function's own scales (arcsine: ln w^2 =
// 1.4 for every weight; squared exponential: l = 0.5); sigma_f = 1, sigma_n = 0.5.
Hyperparameters DefaultHyperparameters(kernels::CovarianceFunction function,
                                       int64_t input_dimension);

// lower_t <= theta_t <= upper_t for every element.
struct HyperparameterBounds {
  std::vector<double> lower;
  std::vector<double> upper;

  // The function's own bounds of the scales (arcsine: ln w^2 in [-5, 7]; squared exponential: l in
  // [0.02, 20]); sigma_f in [0.2, 5]; sigma_n in [0.1, 1.5].
  static HyperparameterBounds Default(kernels::CovarianceFunction function,
                                      int64_t input_dimension);
  // Clamps theta to the bounds.
  void Clamp(std::vector<double>& theta) const;
  bool Contains(absl::Span<const double> theta) const;
  // InvalidArgument unless both have `count` finite elements and lower <= upper.
  absl::Status Validate(int64_t count) const;
};

// theta uniform within the bounds: the paper starts from random hyperparameters.
Hyperparameters RandomHyperparameters(kernels::CovarianceFunction function, int64_t input_dimension,
                                      const HyperparameterBounds& bounds, uint64_t seed);

// The prior variance of f, k(x, x), in float64.
// x: D values; `covariance` valid.
double PriorVariance(const kernels::CovarianceParameters& covariance, const double* x);

// The largest at the points x, n x D; sigma_f^2 without points.
double LargestPriorVariance(const kernels::CovarianceParameters& covariance,
                            kernels::ConstMatrixView<double> x);

}  // namespace egosieve::gp
