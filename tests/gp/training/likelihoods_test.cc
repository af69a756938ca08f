#include <cmath>
#include <tuple>
#include <vector>

#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "gp/training/bounded_ascent.h"
#include "gp/training/marginal_likelihood.h"
#include "gp/training/sparse_likelihood.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

absl::StatusOr<MarginalLikelihood> Likelihood(
    const Hyperparameters& theta, const RowMatrix& x, const std::vector<double>& y,
    LikelihoodOrder order = LikelihoodOrder::kValueAndGradient) {
  return ComputeMarginalLikelihood(*TestContext(), theta, {ViewOf(x), y}, order);
}

class GradientLaw : public testing::TestWithParam<std::tuple<CovarianceFunction, int, int>> {};

TEST_P(GradientLaw, EqualsFiniteDifferences) {
  const auto [function, dimension, n] = GetParam();
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(n, dimension, generator);
  const std::vector<double> y = points.targets();
  const Hyperparameters theta = UnevenHyperparameters(function, dimension);
  const auto at = Value(Likelihood(theta, points.inputs, y));
  const std::vector<double> logarithms = ToLogarithms(theta);
  ASSERT_EQ(at.gradient.size(), logarithms.size());
  for (size_t t = 0; t < logarithms.size(); ++t) {
    // With h = 1e-3: truncation h^4/30 times the fifth derivative, about 1e-13 of
    // the value's scale; rounding eps cond(K) |value| / h, cond(K) about n / 0.09.
    const double h = 1e-3;
    const auto value = [&](double step) {
      std::vector<double> moved = logarithms;
      moved[t] += step;
      return Likelihood(*FromLogarithms(theta, moved), points.inputs, y, LikelihoodOrder::kValue)
          ->value;
    };
    const double tolerance = 1e-9 * (1.0 + n) + 2.2e-16 * n / 0.09 * std::abs(at.value) / h;
    EXPECT_NEAR(at.gradient[t], FivePointSlope(value, h), tolerance) << "theta_" << t;
  }
}

INSTANTIATE_TEST_SUITE_P(Covariances, GradientLaw,
                         testing::Combine(testing::Values(CovarianceFunction::kArcsine,
                                                          CovarianceFunction::kSquaredExponential),
                                          testing::Values(1, 6, 32),
                                          testing::Values(1, 2, 65, 200)));

TEST(MarginalLikelihood, NoPointsAndBadPoints) {
  const Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 2);
  const auto nothing = Value(Likelihood(theta, RowMatrix(0, 2), {}));
  EXPECT_EQ(nothing.value, 0.0);
  EXPECT_EQ(nothing.gradient, std::vector<double>(5, 0.0));
  const RowMatrix x = RowMatrix::Zero(2, 2);
  EXPECT_THAT(Likelihood(theta, x, {1.0}), IsInvalid());
  EXPECT_THAT(Likelihood(theta, x, {1.0, std::nan("")}), IsInvalid());
  Hyperparameters noiseless = theta;
  noiseless.noise_stddev = 1e-12;
  EXPECT_EQ(Likelihood(noiseless, x, {1.0, 1.0}).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(MarginalLikelihood, GpmlsNumbers) {
  const RegressionData data = GpmlDemo();
  const auto at =
      Value(Likelihood(GpmlNeuralNetwork(0.0, 0.0, std::log(0.1)), data.inputs, data.targets));
  EXPECT_NEAR(at.value, -224.6467058483673, 224.6 * 1e-10);
  // GPML differentiates the negative by log ell; log w = -log ell - log sqrt 2 for both weights.
  EXPECT_NEAR(at.gradient[0] + at.gradient[1], 121.0143804398566, 121.0 * 1e-10);
  EXPECT_NEAR(at.gradient[2], 88.35929876048047, 88.4 * 1e-10);
  EXPECT_NEAR(at.gradient[3], 378.1658080336186, 378.2 * 1e-10);
}

TEST(MarginalLikelihood, GpmlsOptimum) {
  const RegressionData data = GpmlDemo();
  // Ascent in (log ell, log sf, log sigma_n), as GPML parameterises it.
  const auto f = [&](const std::vector<double>& t,
                     std::vector<double>& gradient) -> absl::StatusOr<double> {
    const auto at =
        Value(Likelihood(GpmlNeuralNetwork(t[0], t[1], t[2]), data.inputs, data.targets));
    gradient = {-(at.gradient[0] + at.gradient[1]), at.gradient[2], at.gradient[3]};
    return at.value;
  };
  const auto found = Value(Ascend(f, {0.0, 0.0, std::log(0.1)},
                                  {{-5.0, -5.0, -5.0}, {5.0, 5.0, 5.0}}, {.tolerance = 1e-7}));
  EXPECT_NEAR(-found.value, 13.29869998982837, 1e-6);
  EXPECT_NEAR(found.theta[0], -1.590889084812666, 1e-5);
  EXPECT_NEAR(found.theta[1], 1.130955225185297, 1e-5);
}

// The device's factorisation gives what the host's does.
TEST(MarginalLikelihoodOnTheDevice, IsTheHosts) {
  if (TestContext()->is_reference()) GTEST_SKIP() << "the reference has no device";
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(100, 3, generator);
  const std::vector<double> y = points.targets();
  const std::vector<double> noise(100, 0.03);
  Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 3);
  const Observations data(ViewOf(points.inputs), y, noise);
  const auto on_device = Value(kernels::OpenContext({.shared_memory = false}));
  const auto reference = Value(kernels::OpenContext({.device = "reference"}));  // the host
  constexpr LikelihoodOrder kAll = LikelihoodOrder::kValueAndGradient;
  const auto device = Value(ComputeMarginalLikelihood(*on_device, theta, data, kAll));
  const auto host = Value(ComputeMarginalLikelihood(*reference, theta, data, kAll));
  // Rounding errors by a condition of about n / 0.09.
  const double relative = 100.0 * 2.2e-16 * 100.0 / 0.09;
  EXPECT_NEAR(device.value, host.value, relative * std::abs(host.value));
  ASSERT_EQ(device.gradient.size(), host.gradient.size());
  for (size_t t = 0; t < host.gradient.size(); ++t) {
    EXPECT_NEAR(device.gradient[t], host.gradient[t], relative * 100.0 * 100.0);
  }
  theta.noise_stddev = 1e-12;
  const std::vector<double> none(100, 0.0);
  RowMatrix twice = points.inputs;
  twice.row(60) = twice.row(7);
  const auto refused = ComputeMarginalLikelihood(*on_device, theta, {ViewOf(twice), y, none},
                                                 LikelihoodOrder::kValue);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kFailedPrecondition);
}

constexpr SparseApproximation kBoth[] = {SparseApproximation::kDtc, SparseApproximation::kFitc};

struct Problem {
  RowMatrix x, inducing;
  std::vector<double> y, noise;
  Hyperparameters theta;

  Problem(const char* function, int64_t n, int64_t m) {
    auto generator = TestGenerator();
    theta = UnevenHyperparameters(*CovarianceFunction::Parse(function), 3);
    x = RandomPoints(n, 3, generator);
    inducing = RandomPoints(m, 3, generator);
    for (int64_t i = 0; i < n; ++i) {
      y.push_back(std::sin(3.0 * x(i, 0)) + x(i, 1));
      noise.push_back(0.1 * std::abs(x(i, 2)));
    }
  }
  Observations data() const { return {ViewOf(x), absl::MakeConstSpan(y), noise}; }

  MarginalLikelihood At(const Hyperparameters& there, const RowMatrix& u,
                        SparseApproximation kind) const {
    return Value(ComputeSparseLikelihood(*TestContext(), there, data(), ViewOf(u),
                                         LikelihoodOrder::kValueAndGradient,
                                         {.approximation = kind}));
  }
};

TEST(SparseLikelihood, GradientsAreFiniteDifferences) {
  for (const char* function : {"arcsine", "matern32", "linear + squared_exponential"}) {
    for (const SparseApproximation objective : kBoth) {
      const Problem problem(function, 60, 9);
      const MarginalLikelihood at = problem.At(problem.theta, problem.inducing, objective);
      const std::vector<double> theta = ToLogarithms(problem.theta);
      ASSERT_EQ(at.gradient.size(), theta.size());
      for (size_t t = 0; t < theta.size(); ++t) {
        // Five-point rule: h^4 / 30 times a fifth derivative of the value's size or so, and
        // eps cond(A) / h of it.
        const auto value = [&](double step) {
          std::vector<double> moved = theta;
          moved[t] += step;
          return problem.At(*FromLogarithms(problem.theta, moved), problem.inducing, objective)
              .value;
        };
        EXPECT_NEAR(at.gradient[t], FivePointSlope(value, 1e-3), 1e-7 * (1.0 + std::abs(at.value)))
            << function << " theta_" << t;
      }
    }
  }
}

TEST(SparseLikelihood, IsTheExactOneWithAllPointsInducing) {
  const Problem problem("arcsine", 50, 1);
  const auto exact = Value(ComputeMarginalLikelihood(*TestContext(), problem.theta, problem.data(),
                                                     LikelihoodOrder::kValueAndGradient));
  for (const SparseApproximation objective : kBoth) {
    const MarginalLikelihood sparse = problem.At(problem.theta, problem.x, objective);
    // K_uu's jitter, 1e-6 sigma_n^2, moves Q by as much, and the trace by n 1e-6 / 2.
    EXPECT_NEAR(sparse.value, exact.value, 1e-3);
    for (size_t t = 0; t < exact.gradient.size(); ++t) {
      EXPECT_NEAR(sparse.gradient[t], exact.gradient[t], 1e-2) << "theta_" << t;
    }
  }
}

TEST(SparseLikelihood, VfeIsABoundThatInducingInputsTighten) {
  const Problem problem("squared_exponential", 80, 12);
  const auto exact = Value(ComputeMarginalLikelihood(*TestContext(), problem.theta, problem.data(),
                                                     LikelihoodOrder::kValue));
  double before = -INFINITY;
  for (int64_t m = 1; m <= 12; ++m) {
    const RowMatrix u = problem.inducing.topRows(m);
    const double bound = problem.At(problem.theta, u, SparseApproximation::kDtc).value;
    // Titsias (2009): more inducing inputs never loosen the bound; the jitter is 1e-6 of the noise.
    EXPECT_GE(bound, before - 1e-3);
    EXPECT_LE(bound, exact.value + 1e-3);
    before = bound;
  }
}

TEST(SparseLikelihood, FitcIsTheModelsOwn) {
  const Problem problem("matern52", 70, 10);
  const SparseModelOptions options{.approximation = SparseApproximation::kFitc};
  auto model = Value(SparseModel::Create(TestContext(), problem.theta, options));
  ASSERT_TRUE(model.AddObservations(problem.data(), 0).ok());
  ASSERT_TRUE(model.SetInducingInputs(ViewOf(problem.inducing)).ok());
  EXPECT_NEAR(problem.At(problem.theta, problem.inducing, SparseApproximation::kFitc).value,
              model.LogMarginalLikelihood(), 1e-10 * 70);
}

}  // namespace
}  // namespace egosieve::gp
