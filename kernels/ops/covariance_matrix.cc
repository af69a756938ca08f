#include "kernels/ops/covariance_matrix.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/prepared_points.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/opencl_covariance.h"
#include "kernels/reference/covariance.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels {
namespace {

constexpr double kFlopsPerInput = 10.0;  // of a derivative, approximately

absl::Status CheckBoth(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                       ConstMatrixView<double> z) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  return CheckPoints("z", parameters, z);
}

bool RunsOnHost(const Context& context) {
  return context.is_reference() || !context.info().float64;
}

}  // namespace

absl::Status CovarianceMatrix(Context& context, const CovarianceParameters& parameters,
                              ConstMatrixView<double> x, double noise_variance, Triangle triangle,
                              MatrixView<double> out) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, x.rows, x.rows));
  EGOSIEVE_RETURN_IF_ERROR(
      CheckOptions({{"noise_variance", noise_variance, IsNotNegative(noise_variance),
                     "be finite and at least 0"}}));
  const bool lower_only = triangle == Triangle::kLower;
  if (RunsOnHost(context)) {
    reference::CovarianceBlock(parameters, x, x, lower_only, out);
  } else {
    EGOSIEVE_RETURN_IF_ERROR(opencl::CovarianceBlock(context, parameters, x, x, lower_only, out));
  }
  for (int64_t i = 0; i < out.rows; ++i) out(i, i) += noise_variance;
  return absl::OkStatus();
}

absl::Status CrossCovariance(Context& context, const CovarianceParameters& parameters,
                             ConstMatrixView<double> x, ConstMatrixView<double> z,
                             MatrixView<double> out) {
  EGOSIEVE_RETURN_IF_ERROR(CheckBoth(parameters, x, z));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, x.rows, z.rows));
  if (RunsOnHost(context)) {
    reference::CovarianceBlock(parameters, x, z, false, out);
    return absl::OkStatus();
  }
  return opencl::CovarianceBlock(context, parameters, x, z, false, out);
}

absl::StatusOr<std::vector<double>> CovarianceGradient(Context& context,
                                                       const CovarianceParameters& parameters,
                                                       ConstMatrixView<double> x,
                                                       ConstMatrixView<double> w) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("w", w, x.rows, x.rows));
  for (int64_t i = 0; i < w.rows; ++i) {
    // Only the lower triangle is read, so only its values must be finite.
    EGOSIEVE_RETURN_IF_ERROR(CheckFinite(absl::StrCat("row ", i, " of w: w"),
                                         ConstMatrixView<double>(w.row(i), 1, i + 1)));
  }
  if (RunsOnHost(context)) {
    return reference::CovarianceGradient(parameters, x, x, w, true);
  }
  return opencl::CovarianceGradient(context, parameters, x, x, w, true);
}

absl::StatusOr<std::vector<double>> CrossCovarianceGradient(Context& context,
                                                            const CovarianceParameters& parameters,
                                                            ConstMatrixView<double> x,
                                                            ConstMatrixView<double> z,
                                                            ConstMatrixView<double> w) {
  EGOSIEVE_RETURN_IF_ERROR(CheckBoth(parameters, x, z));
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("w", w, x.rows, z.rows));
  EGOSIEVE_RETURN_IF_ERROR(CheckFinite("w", w));
  if (RunsOnHost(context)) {
    return reference::CovarianceGradient(parameters, x, z, w, false);
  }
  return opencl::CovarianceGradient(context, parameters, x, z, w, false);
}

absl::StatusOr<std::vector<double>> VarianceGradient(const CovarianceParameters& parameters,
                                                     ConstMatrixView<double> x,
                                                     absl::Span<const double> weights) {
  EGOSIEVE_RETURN_IF_ERROR(parameters.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints("x", parameters, x));
  EGOSIEVE_REQUIRE(InvalidArgument, static_cast<int64_t>(weights.size()) == x.rows,
                   "%d weights for %d points", weights.size(), x.rows);
  return reference::VarianceGradient(parameters, x, weights.data());
}

absl::Status CovarianceInputGradient(const CovarianceParameters& parameters,
                                     ConstMatrixView<double> x, ConstMatrixView<double> z,
                                     ConstMatrixView<double> w, MatrixView<double> out) {
  EGOSIEVE_RETURN_IF_ERROR(CheckBoth(parameters, x, z));
  const int64_t dimension = parameters.input_dimension();
  EGOSIEVE_RETURN_IF_ERROR(CheckShape("out", out, x.rows, dimension));
  // A stride of 0 has one row for all.
  EGOSIEVE_REQUIRE(InvalidArgument, w.rows == x.rows && w.cols == z.rows,
                   "w is %d x %d; it must be %d x %d", w.rows, w.cols, x.rows, z.rows);
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
