#include "kernels/ops/input_gradient.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_format.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/prepared_points.h"
#include "kernels/base/status_macros.h"

namespace egosieve::kernels {
namespace {

constexpr double kFlopsPerInput = 10.0;  // of a derivative, approximately

absl::Status CheckBoth(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                       ConstMatrixView<double> z) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  return CheckPoints("z", parameters, z);
}

}  // namespace

absl::Status CovarianceInputGradient(const CovarianceParameters& parameters,
                                     ConstMatrixView<double> x, ConstMatrixView<double> z,
                                     ConstMatrixView<double> w, MatrixView<double> out) {
  EGOSIEVE_RETURN_IF_ERROR(CheckBoth(parameters, x, z));
  const int64_t dimension = parameters.input_dimension();
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, x.rows, dimension));
  if (w.rows != x.rows || w.cols != z.rows) {  // a stride of 0 has one row for all
    return absl::InvalidArgumentError(
        absl::StrFormat("w is %d x %d; it must be %d x %d", w.rows, w.cols, x.rows, z.rows));
  }
  const PreparedRows a(parameters, x), b(parameters, z);
  const CovarianceDescription& function = parameters.function.description();
  const double signal_variance = parameters.signal_stddev * parameters.signal_stddev;
  ParallelFor(x.rows, kFlopsPerInput * x.rows * z.rows * dimension, [&](int64_t i) {
    double* gradient = out.row(i);
    std::fill_n(gradient, dimension, 0.0);
    for (int64_t j = 0; j < z.rows; ++j) {
      function.AddInputGradient(parameters.scales.data(), dimension, a.row(i), b.row(j), w(i, j),
                                gradient);
    }
    for (int64_t d = 0; d < dimension; ++d) gradient[d] *= signal_variance;
  });
  return absl::OkStatus();
}

absl::Status CovarianceDerivatives(const CovarianceParameters& parameters,
                                   ConstMatrixView<double> x, ConstMatrixView<double> z,
                                   MatrixView<double> by_logarithms, MatrixView<double> by_input) {
  EGOSIEVE_RETURN_IF_ERROR(CheckBoth(parameters, x, z));
  const int64_t dimension = parameters.input_dimension();
  const int64_t scales = static_cast<int64_t>(parameters.scales.size());
  if (by_logarithms.data != nullptr) {
    EGOSIEVE_RETURN_IF_ERROR(
        CheckShape("by_logarithms", by_logarithms, x.rows * z.rows, scales + 1));
  }
  if (by_input.data != nullptr) {
    EGOSIEVE_RETURN_IF_ERROR(CheckShape("by_input", by_input, x.rows * z.rows, dimension));
  }
  const PreparedRows a(parameters, x), b(parameters, z);
  const CovarianceDescription& function = parameters.function.description();
  const double signal_variance = parameters.signal_stddev * parameters.signal_stddev;
  ParallelFor(x.rows, kFlopsPerInput * x.rows * z.rows * dimension, [&](int64_t i) {
    for (int64_t j = 0; j < z.rows; ++j) {
      const double *p = a.row(i), *q = b.row(j);
      if (by_logarithms.data != nullptr) {
        double* row = by_logarithms.row(i * z.rows + j);
        std::fill_n(row, scales, 0.0);
        function.AddGradient(dimension, p, q, signal_variance, row);
        row[scales] = 2.0 * signal_variance * function.Value(dimension, p, q);
      }
      if (by_input.data != nullptr) {
        double* row = by_input.row(i * z.rows + j);
        std::fill_n(row, dimension, 0.0);
        function.AddInputGradient(parameters.scales.data(), dimension, p, q, signal_variance, row);
      }
    }
  });
  return absl::OkStatus();
}

void PriorVarianceGradient(const CovarianceParameters& parameters, const double* x, double* out) {
  const PointPreparation preparation(parameters);
  std::vector<double> point(preparation.width());
  preparation.Prepare(x, point.data(), 1);
  std::fill_n(out, parameters.input_dimension(), 0.0);
  parameters.function.description().AddInputGradient(
      parameters.scales.data(), parameters.input_dimension(), point.data(), point.data(),
      2.0 * parameters.signal_stddev * parameters.signal_stddev, out);
}

}  // namespace egosieve::kernels
