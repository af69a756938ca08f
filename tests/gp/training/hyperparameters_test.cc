#include "gp/covariance/hyperparameters.h"

#include <cmath>
#include <limits>
#include <vector>

#include "gp/covariance/prior_variance.h"
#include "gtest/gtest.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

TEST(Hyperparameters, LogarithmsGoThereAndBack) {
  for (const auto function :
       {CovarianceFunction::kArcsine, CovarianceFunction::kSquaredExponential}) {
    const HyperparameterBounds bounds = HyperparameterBounds::Default(function, 6);
    const Hyperparameters theta = RandomHyperparameters(function, 6, bounds, 3);
    EXPECT_EQ(theta.covariance.input_dimension(), 6);
    EXPECT_TRUE(bounds.Validate(theta.count()).ok());
    const std::vector<double> logarithms = ToLogarithms(theta);
    EXPECT_TRUE(bounds.Contains(logarithms));
    const auto back = Value(FromLogarithms(function, logarithms));
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
  EXPECT_FALSE(FromLogarithms(CovarianceFunction::kArcsine, {0.0, 0.0}).ok());
  EXPECT_FALSE(FromLogarithms(CovarianceFunction::kArcsine, {0.0, 0.0, 800.0, 0.0}).ok());
  EXPECT_FALSE(FromLogarithms(CovarianceFunction::kArcsine, {0.0, std::nan(""), 0.0, 0.0}).ok());
  HyperparameterBounds bounds = HyperparameterBounds::Default(CovarianceFunction::kArcsine, 2);
  EXPECT_FALSE(bounds.Validate(4).ok());
  bounds.lower[1] = 100.0;
  EXPECT_FALSE(bounds.Validate(5).ok());
  bounds.lower[1] = std::nan("");
  EXPECT_FALSE(bounds.Validate(5).ok());
  EXPECT_FALSE(bounds.Contains({0.0, 0.0}));
}

TEST(PriorVariance, FollowsTheCovariance) {
  kernels::CovarianceParameters parameters;
  parameters.scales = {0.5, 2.0};
  parameters.signal_stddev = 1.5;
  const double x = 0.3, aa = 2.0 * (0.25 + 4.0 * 0.09);
  EXPECT_NEAR(PriorVariance(parameters, &x), 2.25 * std::asin(aa / (1.0 + aa)), 1e-15);
  // Where asin's argument rounds to 1: pi/2 - sqrt(2 e), e = 1 - z = 1 / (1 + a.a).
  parameters.scales = {1e9, 1.0};
  EXPECT_NEAR(PriorVariance(parameters, &x) / 2.25, M_PI_2 - 1e-9, 1e-15);
  parameters.function = CovarianceFunction::kSquaredExponential;
  EXPECT_EQ(PriorVariance(parameters, &x), 2.25);
}

}  // namespace
}  // namespace egosieve::gp
