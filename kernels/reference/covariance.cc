#include "kernels/reference/covariance.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/prepared_points.h"

namespace egosieve::kernels::reference {
namespace {

constexpr double kHalfPi = 1.57079632679489661923;

// Prepared points, one a row of components + 1 values.
class PreparedRows {
 public:
  PreparedRows(const CovarianceParameters& parameters, ConstMatrixView<double> x)
      : stride_(PreparedComponents(parameters) + 1), values_(x.rows * stride_) {
    for (int64_t i = 0; i < x.rows; ++i) {
      PreparePoint(parameters, x.row(i), &values_[i * stride_], 1);
    }
  }
  const double* row(int64_t i) const { return &values_[i * stride_]; }

 private:
  int64_t stride_;
  std::vector<double> values_;
};

struct ArcsineTerms {
  double sign;  // s
  double h;     // (1 - |z|) / 2
};

ArcsineTerms EvaluateTerms(int64_t components, const double* a, const double* b) {
  double dot = 0.0;
  for (int64_t c = 0; c < components; ++c) {
    dot += a[c] * b[c];
  }
  const double sign = dot < 0.0 ? -1.0 : 1.0;
  double h = a[components] + b[components];
  for (int64_t c = 0; c < components; ++c) {
    const double difference = a[c] - sign * b[c];
    h += difference * difference;
  }
  return {sign, std::min(h, 0.5)};
}

// k / sigma_f^2 of two prepared points.
double UnitCovariance(CovarianceFunction function, int64_t components, const double* a,
                      const double* b) {
  if (function == CovarianceFunction::kArcsine) {
    const ArcsineTerms terms = EvaluateTerms(components, a, b);
    return terms.sign * (kHalfPi - 2.0 * std::asin(std::sqrt(terms.h)));
  }
  double squared_distance = 0.0;
  for (int64_t c = 0; c < components; ++c) {
    squared_distance += (a[c] - b[c]) * (a[c] - b[c]);
  }
  return std::exp(-0.5 * squared_distance);
}

// Adds weight * dk/dlog theta_t / sigma_f^2 to gradient[t].
void AddPairGradient(CovarianceFunction function, int64_t components, const double* a,
                     const double* b, double weight, double* gradient) {
  gradient[components] += 2.0 * weight * UnitCovariance(function, components, a, b);
  if (function == CovarianceFunction::kArcsine) {
    const auto [sign, h] = EvaluateTerms(components, a, b);
    // The stored components are halves: 4 (a/2)^2 = a^2.
    const double factor = weight * sign * 4.0 / (2.0 * std::sqrt(h * (1.0 - h)));
    for (int64_t c = 0; c < components; ++c) {
      const double difference = a[c] - sign * b[c];
      gradient[c] += factor * (2.0 * h * (a[c] * a[c] + b[c] * b[c]) - difference * difference);
    }
    return;
  }
  const double factor = weight * UnitCovariance(function, components, a, b);
  for (int64_t c = 0; c < components; ++c) {
    gradient[c] += factor * (a[c] - b[c]) * (a[c] - b[c]);
  }
}

}  // namespace

double Covariance(const CovarianceParameters& parameters, const double* x, const double* z) {
  const int64_t components = PreparedComponents(parameters);
  double a[kMaxInputDimension + 2];
  double b[kMaxInputDimension + 2];
  PreparePoint(parameters, x, a, 1);
  PreparePoint(parameters, z, b, 1);
  return parameters.signal_stddev * parameters.signal_stddev *
         UnitCovariance(parameters.function, components, a, b);
}

template <typename T>
void CovarianceBlock(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                     ConstMatrixView<double> z, bool lower_only, MatrixView<T> out) {
  const int64_t components = PreparedComponents(parameters);
  const double signal_variance = parameters.signal_stddev * parameters.signal_stddev;
  const PreparedRows a(parameters, x);
  const PreparedRows b(parameters, z);
  for (int64_t i = 0; i < x.rows; ++i) {
    const int64_t end = lower_only ? std::min(i + 1, z.rows) : z.rows;
    for (int64_t j = 0; j < end; ++j) {
      out(i, j) = static_cast<T>(
          signal_variance * UnitCovariance(parameters.function, components, a.row(i), b.row(j)));
    }
  }
}

template void CovarianceBlock(const CovarianceParameters&, ConstMatrixView<double>,
                              ConstMatrixView<double>, bool, MatrixView<float>);
template void CovarianceBlock(const CovarianceParameters&, ConstMatrixView<double>,
                              ConstMatrixView<double>, bool, MatrixView<double>);

std::vector<double> CovarianceGradient(const CovarianceParameters& parameters,
                                       ConstMatrixView<double> x, ConstMatrixView<double> w) {
  const int64_t components = PreparedComponents(parameters);
  const PreparedRows a(parameters, x);
  std::vector<double> gradient(components + 1, 0.0);
  for (int64_t i = 0; i < x.rows; ++i) {
    for (int64_t j = 0; j <= i; ++j) {
      const double weight = i == j ? w(i, j) : 2.0 * w(i, j);
      AddPairGradient(parameters.function, components, a.row(i), a.row(j), weight, gradient.data());
    }
  }
  for (double& value : gradient) {
    value *= parameters.signal_stddev * parameters.signal_stddev;
  }
  return gradient;
}

}  // namespace egosieve::kernels::reference
