#include "kernels/reference/covariance.h"

#include <algorithm>

#include "kernels/base/prepared_points.h"

namespace egosieve::kernels::reference {
double Covariance(const CovarianceParameters& parameters, const double* x, const double* z) {
  const PointPreparation preparation(parameters);
  std::vector<double> a(preparation.width()), b(preparation.width());
  preparation.Prepare(x, a.data(), 1);
  preparation.Prepare(z, b.data(), 1);
  return parameters.signal_stddev * parameters.signal_stddev *
         parameters.function.description().Value(parameters.input_dimension(), a.data(), b.data());
}

void CovarianceBlock(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                     ConstMatrixView<double> z, bool lower_only, MatrixView<double> out) {
  const CovarianceDescription& function = parameters.function.description();
  const int64_t dimension = parameters.input_dimension();
  const double signal_variance = parameters.signal_stddev * parameters.signal_stddev;
  const PreparedRows a(parameters, x);
  const PreparedRows b(parameters, z);
  for (int64_t i = 0; i < x.rows; ++i) {
    const int64_t end = lower_only ? std::min(i + 1, z.rows) : z.rows;
    for (int64_t j = 0; j < end; ++j) {
      out(i, j) = signal_variance * function.Value(dimension, a.row(i), b.row(j));
    }
  }
}

namespace {

// Sums weight_ij dk(x_i, z_j) / d log theta over the pairs that `visit(add)` passes as add(i, j,
// weight).
template <typename Visit>
std::vector<double> SumOfGradients(const CovarianceParameters& parameters,
                                   ConstMatrixView<double> x, ConstMatrixView<double> z,
                                   const Visit& visit) {
  const CovarianceDescription& function = parameters.function.description();
  const int64_t dimension = parameters.input_dimension();
  const PreparedRows a(parameters, x), b(parameters, z);
  std::vector<double> gradient(parameters.scales.size() + 1, 0.0);
  visit([&](int64_t i, int64_t j, double weight) {
    function.AddGradient(dimension, a.row(i), b.row(j), weight, gradient.data());
    gradient.back() += 2.0 * weight * function.Value(dimension, a.row(i), b.row(j));
  });
  for (double& value : gradient) value *= parameters.signal_stddev * parameters.signal_stddev;
  return gradient;
}

}  // namespace

std::vector<double> CovarianceGradient(const CovarianceParameters& parameters,
                                       ConstMatrixView<double> x, ConstMatrixView<double> z,
                                       ConstMatrixView<double> w, bool lower_only) {
  return SumOfGradients(parameters, x, z, [&](const auto& add) {
    for (int64_t i = 0; i < x.rows; ++i) {
      const int64_t end = lower_only ? i + 1 : z.rows;
      for (int64_t j = 0; j < end; ++j) add(i, j, lower_only && j < i ? 2.0 * w(i, j) : w(i, j));
    }
  });
}

std::vector<double> VarianceGradient(const CovarianceParameters& parameters,
                                     ConstMatrixView<double> x, const double* w) {
  return SumOfGradients(parameters, x, x, [&](const auto& add) {
    for (int64_t i = 0; i < x.rows; ++i) add(i, i, w[i]);
  });
}

}  // namespace egosieve::kernels::reference
