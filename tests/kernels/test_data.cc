#include "tests/kernels/test_data.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "kernels/reference/covariance.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {

std::mt19937_64 TestRandom() {
  const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
  const std::string name = std::string(test->test_suite_name()) + "." + test->name();
  std::seed_seq seed(name.begin(), name.end());
  return std::mt19937_64(seed);
}

double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * std::ldexp(static_cast<double>(random() >> 11), -53);
}

std::vector<double> RandomPoints(std::mt19937_64& random, int64_t n, int64_t dimension) {
  std::vector<double> points(n * dimension);
  for (double& value : points) value = Uniform(random, -1.0, 1.0);
  return points;
}

CovarianceParameters ArcsineParameters(std::vector<double> weights, double signal_stddev) {
  return {CovarianceFunction::kArcsine, std::move(weights), signal_stddev};
}

CovarianceParameters SquaredExponentialParameters(std::vector<double> lengths,
                                                  double signal_stddev) {
  return {CovarianceFunction::kSquaredExponential, std::move(lengths), signal_stddev};
}

long double ExactCovariance(const CovarianceParameters& parameters, const double* x,
                            const double* z) {
  using Real = long double;
  const int64_t dimension = parameters.input_dimension();
  const Real signal_variance = Real(parameters.signal_stddev) * parameters.signal_stddev;
  if (parameters.function == CovarianceFunction::kSquaredExponential) {
    Real square = 0;
    for (int64_t d = 0; d < dimension; ++d) {
      const Real difference = (Real(x[d]) - z[d]) / parameters.scales[d];
      square += difference * difference;
    }
    return signal_variance * std::exp(-square / 2);
  }
  // atan2 of |a x b| and a.b for a = (a, 1) / norm in one more dimension each: with u = a.b, A = 1
  // + a.a, B = 1 + b.b, sqrt(A B - u^2) from Lagrange's identity sum (a_i b_j - a_j b_i)^2 + a.a +
  // b.b + 1, in which nothing cancels twice.
  const int64_t components = dimension + 1;
  std::vector<Real> a(components), b(components);
  for (int64_t c = 0; c < components; ++c) {
    const Real weight = std::sqrt(Real(2)) * parameters.scales[c];
    a[c] = c == 0 ? weight : weight * x[c - 1];
    b[c] = c == 0 ? weight : weight * z[c - 1];
  }
  Real dot = 0, rest = 1;
  for (int64_t i = 0; i < components; ++i) {
    dot += a[i] * b[i];
    rest += a[i] * a[i] + b[i] * b[i];
    for (int64_t j = 0; j < i; ++j) {
      const Real cross = a[i] * (b[j] - a[j]) - a[j] * (b[i] - a[i]);
      rest += cross * cross;
    }
  }
  return signal_variance * std::atan2(dot, std::sqrt(rest));
}

PosteriorModel Problem::model(FactorKind kind) const {
  PosteriorModel model{
      .covariance = covariance,
      .inputs = ConstMatrixView<double>(inputs.data(), count, covariance.input_dimension()),
      .alpha = alpha.data(),
      .factor_kind = kind};
  const std::vector<double>& factor = kind == FactorKind::kInverseCholesky ? inverse : cholesky;
  model.factor = ConstMatrixView<double>(factor.data(), count, count);
  model.squash_a = 1.7;
  model.squash_b = -0.2;
  return model;
}

Problem MakeProblem(std::mt19937_64& random, const CovarianceParameters& covariance, int64_t n,
                    double noise_stddev) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Problem problem{.covariance = covariance, .count = n};
  const int64_t dimension = covariance.input_dimension();
  problem.inputs = RandomPoints(random, n, dimension);
  problem.cholesky.assign(n * n, 0.0);
  const ConstMatrixView<double> x(problem.inputs.data(), n, dimension);
  reference::CovarianceBlock(covariance, x, x, false,
                             MatrixView<double>(problem.cholesky.data(), n, n));
  Eigen::Map<RowMajor> factor(problem.cholesky.data(), n, n);
  factor.diagonal().array() += noise_stddev * noise_stddev;
  const RowMajor lower = factor.llt().matrixL();
  factor = lower;
  const RowMajor inverse = lower.triangularView<Eigen::Lower>().solve(RowMajor::Identity(n, n));
  problem.inverse.assign(inverse.data(), inverse.data() + n * n);
  Eigen::VectorXd y(n);
  for (int64_t i = 0; i < n; ++i) y[i] = problem.inputs[i * dimension] > 0.1 ? 1.0 : -1.0;
  const Eigen::VectorXd alpha = lower.transpose().triangularView<Eigen::Upper>().solve(
      lower.triangularView<Eigen::Lower>().solve(y));
  problem.alpha.assign(alpha.data(), alpha.data() + n);
  return problem;
}

PosteriorErrorBounds ErrorBounds(const PosteriorModel& model, double noise_stddev) {
  const double u = std::ldexp(1.0, -24);
  const double n = static_cast<double>(model.inputs.rows);
  const double signal = model.covariance.signal_stddev * model.covariance.signal_stddev;
  double alpha_sum = 0.0;
  for (int64_t i = 0; i < model.inputs.rows; ++i) alpha_sum += std::abs(model.alpha[i]);
  const double prior = signal * M_PI / 2;
  const double condition = std::sqrt((n * prior + noise_stddev * noise_stddev)) / noise_stddev;
  const double v = std::sqrt(prior);
  PosteriorErrorBounds bounds{
      .mean = signal * alpha_sum * (1e-6 + (66 + n / 64) * u * M_PI / 2) + 1e-6,
      .variance = 2 * v * (1e-6 * signal * std::sqrt(n) / noise_stddev + 8 * u * condition * v) +
                  (n / 96 + 96) * u * prior};
  bounds.probability = 0.4 * model.squash_a * bounds.mean +
                       0.13 * model.squash_a * model.squash_a * bounds.variance + 1e-6;
  return bounds;
}

std::shared_ptr<Context> TestContext() {
  static const std::shared_ptr<Context> context = Value(OpenContext());
  return context;
}

bool TestIsOnReference() { return TestContext()->is_reference(); }

std::shared_ptr<Context> SideBySideContext() {
  const ContextOptions options{.shared_memory = false, .tuning = DefaultGpuTuning()};
  static const std::shared_ptr<Context> context = Value(OpenContext(options));
  return context;
}

}  // namespace egosieve::kernels
