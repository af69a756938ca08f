#include "gp/training/bounded_ascent.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/status/status.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/training/laplace_approximation.h"
#include "kernels/ops/covariance_matrix.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using kernels::CovarianceFunction;
HyperparameterBounds Box(std::vector<double> lower, std::vector<double> upper) {
  return {.lower = std::move(lower), .upper = std::move(upper)};
}

// Minus Rosenbrock's function; its maximum in the plane is 0 at (1, 1).
absl::StatusOr<double> Valley(const std::vector<double>& x, std::vector<double>& gradient) {
  const double a = 1.0 - x[0], b = x[1] - x[0] * x[0];
  gradient = {2.0 * a + 400.0 * x[0] * b, -200.0 * b};
  return -(a * a + 100.0 * b * b);
}

AscentOptions Tight() { return {.tolerance = 1e-9}; }

TEST(BoundedAscent, FindsTheMaximumOfACurvedValley) {
  const auto found = Value(Ascend(Valley, {-1.2, 1.0}, Box({-5, -5}, {5, 5}), Tight()));
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.theta[0], 1.0, 1e-7);
  EXPECT_NEAR(found.theta[1], 1.0, 1e-7);
}

TEST(BoundedAscent, EndsOnABoundWhereTheGradientPointsOut) {
  // With x <= 1/2 the maximum lies at x = 1/2, y = 1/4.
  const auto found = Value(Ascend(Valley, {-1.2, 1.0}, Box({-5, -5}, {0.5, 5}), Tight()));
  EXPECT_TRUE(found.converged);
  EXPECT_EQ(found.theta[0], 0.5);
  EXPECT_NEAR(found.theta[1], 0.25, 1e-9);
  EXPECT_LE(found.gradient_norm, 1e-9);
}

TEST(BoundedAscent, EveryPlaceThatIsAskedLiesWithinTheBounds) {
  const HyperparameterBounds bounds = Box({-2, 0.5}, {0.5, 0.75});
  const auto found = Ascend(
      [&](const std::vector<double>& x, std::vector<double>& gradient) {
        EXPECT_TRUE(bounds.Contains(x)) << x[0] << ", " << x[1];
        return Valley(x, gradient);
      },
      {9.0, -9.0}, bounds);
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_TRUE(bounds.Contains(found->theta));
}

TEST(BoundedAscent, GoesAroundPlacesWithoutAValue) {
  // log x has no value below 0; log x - x has its maximum at 1.
  const auto found = Ascend(
      [](const std::vector<double>& x, std::vector<double>& gradient) -> absl::StatusOr<double> {
        gradient = {x[0] > 0.0 ? 1.0 / x[0] - 1.0 : 0.0};
        return x[0] > 0.0 ? std::log(x[0]) - x[0] : -std::numeric_limits<double>::infinity();
      },
      {9.0}, Box({-100}, {100}), Tight());
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_NEAR(found->theta[0], 1.0, 1e-8);
}

TEST(BoundedAscent, TellsThatItHasNotConverged) {
  const AscentOptions few{.steps = 2};
  const auto found = Value(Ascend(Valley, {-1.2, 1.0}, Box({-5, -5}, {5, 5}), few));
  EXPECT_FALSE(found.converged);
  EXPECT_GT(found.gradient_norm, few.tolerance);
  std::vector<double> gradient;
  EXPECT_GT(found.value, *Valley({-1.2, 1.0}, gradient));
}

TEST(BoundedAscent, ReturnsTheFunctionsError) {
  const auto found = Ascend(
      [](const std::vector<double>&, std::vector<double>&) -> absl::StatusOr<double> {
        return absl::CancelledError("enough");
      },
      {0.0}, Box({-1}, {1}));
  EXPECT_EQ(found.status().code(), absl::StatusCode::kCancelled);
}

TEST(Hyperparameters, LogarithmsGoThereAndBack) {
  for (const auto function :
       {CovarianceFunction::kArcsine, CovarianceFunction::kSquaredExponential}) {
    const HyperparameterBounds bounds = HyperparameterBounds::Default(function, 6);
    const Hyperparameters theta = RandomHyperparameters(function, 6, bounds, 3);
    EXPECT_EQ(theta.covariance.input_dimension(), 6);
    EXPECT_TRUE(bounds.Validate(theta.count()).ok());
    const std::vector<double> logarithms = ToLogarithms(theta);
    EXPECT_TRUE(bounds.Contains(logarithms));
    const auto back = Value(FromLogarithms(theta, logarithms));
    EXPECT_NEAR(back.noise_stddev, theta.noise_stddev, 1e-15);
    EXPECT_NEAR(back.covariance.scales[2], theta.covariance.scales[2],
                4e-15 * theta.covariance.scales[2]);
    EXPECT_NE(ToLogarithms(RandomHyperparameters(function, 6, bounds, 4)), logarithms);
  }
}

TEST(Hyperparameters, DefaultsLieWithinTheDefaultBounds) {
  const Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 6);
  EXPECT_EQ(theta.covariance.scales.size(), 7u);
  EXPECT_NEAR(2.0 * std::log(theta.covariance.scales[0]), 1.4, 1e-15);
  EXPECT_TRUE(
      HyperparameterBounds::Default(CovarianceFunction::kArcsine, 6).Contains(ToLogarithms(theta)));
}

TEST(Hyperparameters, RefusesNonsense) {
  Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 2);
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    theta.noise_stddev = bad;
    EXPECT_THAT(theta.Validate(), IsInvalid()) << bad;
  }
  const Hyperparameters like = DefaultHyperparameters(CovarianceFunction::kArcsine, 1);
  EXPECT_FALSE(FromLogarithms(like, {0.0, 0.0}).ok());
  EXPECT_FALSE(FromLogarithms(like, {0.0, 0.0, 0.0, 0.0, 0.0}).ok());
  EXPECT_FALSE(FromLogarithms(like, {0.0, 0.0, 800.0, 0.0}).ok());
  EXPECT_FALSE(FromLogarithms(like, {0.0, std::nan(""), 0.0, 0.0}).ok());
  HyperparameterBounds bounds = HyperparameterBounds::Default(CovarianceFunction::kArcsine, 2);
  EXPECT_FALSE(bounds.Validate(4).ok());
  bounds.lower[1] = 100.0;
  EXPECT_FALSE(bounds.Validate(5).ok());
  bounds.lower[1] = std::nan("");
  EXPECT_FALSE(bounds.Validate(5).ok());
  EXPECT_FALSE(bounds.Contains({0.0, 0.0}));
}

TEST(PriorVariance, FollowsTheCovariance) {
  kernels::CovarianceParameters parameters{.scales = {0.5, 2.0}, .signal_stddev = 1.5};
  const double x = 0.3, aa = 2.0 * (0.25 + 4.0 * 0.09);
  EXPECT_NEAR(PriorVariance(parameters, &x), 2.25 * std::asin(aa / (1.0 + aa)), 1e-15);
  // Where asin's argument rounds to 1: pi/2 - sqrt(2 e), e = 1 - z = 1 / (1 + a.a).
  parameters.scales = {1e9, 1.0};
  EXPECT_NEAR(PriorVariance(parameters, &x) / 2.25, M_PI_2 - 1e-9, 1e-15);
  parameters.function = CovarianceFunction::kSquaredExponential;
  EXPECT_EQ(PriorVariance(parameters, &x), 2.25);
}

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
  EXPECT_TRUE(kernels::CovarianceMatrix(*TestContext(), parameters, ViewOf(problem.inputs), 0.0,
                                        kernels::Triangle::kFull, {k.data(), n, n})
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
