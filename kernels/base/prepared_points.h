// Prepared points: coordinates for which covariances are cheap and accurate. They are p(x) of
// kernels/covariance/covariance_function.h, computed in float64 and rounded once.
//
// Functions of differences subtract a centre c before they scale, so that in float32 the rounding
// is relative to |x - c|. c_d is the middle of the inputs' range if zero lies outside of the range.
// Otherwise it is zero: centring would gain less than a factor of two.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::kernels {

// Number of values of a prepared point; at least 1, so that there is an array.
int64_t PreparedWidth(const CovarianceParameters& parameters);

// c, D values.
std::vector<double> CentreOf(ConstMatrixView<double> inputs);

// Prepares the points of one computation. `parameters` must be valid and outlive it.
class PointPreparation {
 public:
  // c = 0.
  explicit PointPreparation(const CovarianceParameters& parameters);
  PointPreparation(const CovarianceParameters& parameters, std::vector<double> centre);

  int64_t width() const { return width_; }
  const std::vector<double>& centre() const { return centre_; }

  // Writes value c of p(x), x of D values, to out[c * step].
  template <typename Input, typename Real>
  void Prepare(const Input* x, Real* out, int64_t step) const;

 private:
  const double* scales_;
  const CovarianceDescription& function_;
  int64_t dimension_;
  int64_t width_;
  std::vector<double> centre_;
};

// The points without a centre, one per row.
class PreparedRows {
 public:
  PreparedRows(const CovarianceParameters& parameters, ConstMatrixView<double> x);
  const double* row(int64_t i) const { return &values_[i * width_]; }

 private:
  int64_t width_;
  std::vector<double> values_;
};

// InvalidArgument, with the `name`, unless the points have the covariance's D and are finite.
absl::Status CheckPoints(std::string_view name, const CovarianceParameters& parameters,
                         ConstMatrixView<double> points);

}  // namespace egosieve::kernels
