#include "gp/training/marginal_likelihood.h"

#include <cmath>
#include <tuple>
#include <vector>

#include "gp/model/exact_model.h"
#include "gp/training/gradient_ascent.h"
#include "gtest/gtest.h"
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
      return Likelihood(*FromLogarithms(function, moved), points.inputs, y, LikelihoodOrder::kValue)
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
  std::vector<double> theta = {0.0, 0.0, std::log(0.1)};
  HyperparameterBounds bounds{{-5.0, -5.0, -5.0}, {5.0, 5.0, 5.0}};
  RpropState state;
  RpropOptions options;
  options.minimum_step = 1e-12;
  double value = 0.0;
  for (int step = 0; step < 1500; ++step) {
    const auto at = Value(
        Likelihood(GpmlNeuralNetwork(theta[0], theta[1], theta[2]), data.inputs, data.targets));
    value = at.value;
    RpropStep({-(at.gradient[0] + at.gradient[1]), at.gradient[2], at.gradient[3]}, bounds, options,
              state, theta);
  }
  EXPECT_NEAR(-value, 13.29869998982837, 1e-6);
  EXPECT_NEAR(theta[0], -1.590889084812666, 1e-5);
  EXPECT_NEAR(theta[1], 1.130955225185297, 1e-5);
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
  const auto at = [&](LikelihoodPlace place) {
    return ComputeMarginalLikelihood(*TestContext(), theta, data,
                                     LikelihoodOrder::kValueAndGradient, place);
  };
  kernels::ContextOptions options;
  options.device = "reference";  // where the host factorises
  const auto reference = Value(kernels::OpenContext(options));
  const auto device = Value(at(LikelihoodPlace::kDevice));
  const auto host =
      Value(ComputeMarginalLikelihood(*reference, theta, data, LikelihoodOrder::kValueAndGradient));
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
  const auto refused = ComputeMarginalLikelihood(*TestContext(), theta, {ViewOf(twice), y, none},
                                                 LikelihoodOrder::kValue, LikelihoodPlace::kDevice);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kFailedPrecondition);
  theta.mean = MeanFunction::kConstant;
  EXPECT_THAT(at(LikelihoodPlace::kDevice), IsInvalid());
}

}  // namespace
}  // namespace egosieve::gp
