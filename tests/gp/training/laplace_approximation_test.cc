#include "gp/training/laplace_approximation.h"

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/ops/covariance_matrix.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using kernels::CovarianceFunction;

struct Problem {
  RowMatrix inputs;
  std::vector<double> labels, weights;

  LabelledInputs view() const { return {ViewOf(inputs), labels, weights}; }
};

Problem MakeProblem(int n) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(n, 2, generator);
  Problem problem{points.inputs, {}, {}};
  int i = 0;
  for (const double target : points.targets()) {
    problem.labels.push_back(target > 0.0 ? 1.0 : -1.0);
    problem.weights.push_back(0.25 * (1 + i++ % 7));
  }
  return problem;
}

kernels::CovarianceParameters Parameters() {
  return UnevenHyperparameters(CovarianceFunction::kSquaredExponential, 2).covariance;
}

absl::StatusOr<LaplaceApproximation> Approximate(const kernels::CovarianceParameters& parameters,
                                                 const Problem& problem,
                                                 LikelihoodOrder order = LikelihoodOrder::kValue) {
  return ApproximateByLaplace(*TestContext(), parameters, problem.view(), order);
}

MatrixXd Covariances(const kernels::CovarianceParameters& parameters, const Problem& problem) {
  const auto n = static_cast<int64_t>(problem.labels.size());
  std::vector<double> k(n * n);
  EXPECT_TRUE(kernels::CovarianceMatrix<double>(*TestContext(), parameters, ViewOf(problem.inputs),
                                                0.0, kernels::Triangle::kFull, {k.data(), n, n})
                  .ok());
  return MatrixXd::Map(k.data(), n, n);
}

// The regression's mean at its points is f^: its stationarity and (LA2), from erfc and Eigen alone.
TEST(LaplaceApproximationTest, IsStationaryAndHasItsLikelihood) {
  const Problem problem = MakeProblem(60);
  const auto laplace = Value(Approximate(Parameters(), problem));
  const MatrixXd k = Covariances(Parameters(), problem);
  const int64_t n = k.rows();
  const VectorXd y = VectorXd::Map(laplace.targets.data(), n);
  const VectorXd variances = VectorXd::Map(laplace.noise_variances.data(), n);
  const VectorXd alpha = (k + MatrixXd(variances.asDiagonal())).ldlt().solve(y);
  const VectorXd f = k * alpha;
  double value = -0.5 * alpha.dot(f);
  for (int64_t i = 0; i < n; ++i) {
    const double t = problem.labels[i], w = problem.weights[i];
    const double phi = 0.5 * std::erfc(-t * f[i] / std::sqrt(2.0));
    const double ratio = std::exp(-0.5 * f[i] * f[i]) / std::sqrt(2.0 * M_PI) / phi;
    EXPECT_NEAR(alpha[i], w * t * ratio, 1e-9) << i;
    EXPECT_NEAR(1.0 / variances[i], w * ratio * (ratio + t * f[i]), 1e-9) << i;
    value += w * std::log(phi);
  }
  const MatrixXd scaled = MatrixXd::Identity(n, n) + variances.cwiseInverse().asDiagonal() * k;
  value -= 0.5 * std::log(scaled.determinant());
  EXPECT_NEAR(laplace.log_likelihood, value, 1e-8);
}

TEST(LaplaceApproximationTest, GradientEqualsFiniteDifferences) {
  const Problem problem = MakeProblem(40);
  const auto at = Value(Approximate(Parameters(), problem, LikelihoodOrder::kValueAndGradient));
  ASSERT_EQ(at.gradient.size(), 3u);
  for (int t = 0; t < 3; ++t) {
    const double h = 1e-3;
    const auto value = [&](double step) {
      kernels::CovarianceParameters moved = Parameters();
      (t < 2 ? moved.scales[t] : moved.signal_stddev) *= std::exp(step);
      return Approximate(moved, problem)->log_likelihood;
    };
    const double difference =
        (value(-2.0 * h) - 8.0 * value(-h) + 8.0 * value(h) - value(2.0 * h)) / (12.0 * h);
    EXPECT_NEAR(at.gradient[t], difference, 1e-8) << t;
  }
}

TEST(LaplaceApproximationTest, AWeightOfTwoIsTwoRows) {
  Problem weighted = MakeProblem(30), repeated = weighted;
  weighted.weights.assign(30, 1.0);
  weighted.weights[4] = 2.0;
  repeated.weights.clear();
  repeated.inputs.conservativeResize(31, 2);
  repeated.inputs.row(30) = repeated.inputs.row(4);
  repeated.labels.push_back(repeated.labels[4]);
  EXPECT_NEAR(Approximate(Parameters(), weighted)->log_likelihood,
              Approximate(Parameters(), repeated)->log_likelihood, 1e-10);
}

TEST(LaplaceApproximationTest, HoldsForLargeLatentValues) {
  Problem problem = MakeProblem(50);
  kernels::CovarianceParameters parameters = Parameters();
  parameters.signal_stddev = 1e4;
  for (size_t i = 0; i < problem.labels.size(); ++i) {
    problem.labels[i] = problem.inputs(i, 0) > 0.0 ? 1.0 : -1.0;
  }
  const auto at = Value(Approximate(parameters, problem, LikelihoodOrder::kValueAndGradient));
  EXPECT_LT(at.log_likelihood, 0.0);
  for (const auto* values : {&at.gradient, &at.targets, &at.noise_variances}) {
    for (const double value : *values) EXPECT_TRUE(std::isfinite(value));
  }
}

TEST(LaplaceApproximationTest, RefusesOtherLabelsAndWeights) {
  Problem problem = MakeProblem(10);
  problem.labels[3] = 0.5;
  EXPECT_THAT(Approximate(Parameters(), problem), IsInvalid());
  problem.labels[3] = 1.0;
  problem.weights[2] = 0.0;
  EXPECT_THAT(Approximate(Parameters(), problem), IsInvalid());
}

}  // namespace
}  // namespace egosieve::gp
