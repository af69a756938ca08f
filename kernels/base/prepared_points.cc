#include "kernels/base/prepared_points.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "absl/container/fixed_array.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::kernels {

int64_t PreparedWidth(const CovarianceParameters& parameters) {
  return std::max<int64_t>(
      parameters.function.description().PointWidth(parameters.input_dimension()), 1);
}

std::vector<double> CentreOf(ConstMatrixView<double> inputs) {
  std::vector<double> low(inputs.cols, 0.0), high(inputs.cols, 0.0);
  for (int64_t i = 0; i < inputs.rows; ++i) {
    const double* x = inputs.row(i);
    for (int64_t d = 0; d < inputs.cols; ++d) {
      low[d] = i == 0 ? x[d] : std::min(low[d], x[d]);
      high[d] = i == 0 ? x[d] : std::max(high[d], x[d]);
    }
  }
  for (int64_t d = 0; d < inputs.cols; ++d) {
    low[d] = low[d] > 0.0 || high[d] < 0.0 ? 0.5 * low[d] + 0.5 * high[d] : 0.0;
  }
  return low;
}

PointPreparation::PointPreparation(const CovarianceParameters& parameters)
    : PointPreparation(parameters, std::vector<double>(parameters.input_dimension(), 0.0)) {}

PointPreparation::PointPreparation(const CovarianceParameters& parameters,
                                   std::vector<double> centre)
    : scales_(parameters.scales.data()),
      function_(parameters.function.description()),
      dimension_(parameters.input_dimension()),
      width_(PreparedWidth(parameters)),
      centre_(std::move(centre)) {}

template <typename Input, typename Real>
void PointPreparation::Prepare(const Input* x, Real* out, int64_t step) const {
  absl::FixedArray<double, 64> point(width_);
  point[0] = 0.0;
  if constexpr (std::is_same_v<Input, double>) {
    function_.Prepare(scales_, dimension_, x, centre_.data(), point.data());
  } else {
    absl::FixedArray<double, 64> wide(dimension_);
    std::copy_n(x, dimension_, wide.begin());
    function_.Prepare(scales_, dimension_, wide.data(), centre_.data(), point.data());
  }
  for (int64_t c = 0; c < width_; ++c) out[c * step] = static_cast<Real>(point[c]);
}

PreparedRows::PreparedRows(const CovarianceParameters& parameters, ConstMatrixView<double> x)
    : width_(PreparedWidth(parameters)), values_(x.rows * width_) {
  const PointPreparation preparation(parameters);
  for (int64_t i = 0; i < x.rows; ++i) preparation.Prepare(x.row(i), &values_[i * width_], 1);
}

absl::Status CheckPoints(std::string_view name, const CovarianceParameters& parameters,
                         ConstMatrixView<double> points) {
  EGOSIEVE_RETURN_IF_ERROR(CheckShape(name, points, points.rows, parameters.input_dimension()));
  return CheckFinite(name, points);
}

template void PointPreparation::Prepare(const double*, double*, int64_t) const;
template void PointPreparation::Prepare(const double*, float*, int64_t) const;
template void PointPreparation::Prepare(const float*, double*, int64_t) const;
template void PointPreparation::Prepare(const float*, float*, int64_t) const;

}  // namespace egosieve::kernels
