#include "gp/calibration/probabilistic_least_squares.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using testing::HasSubstr;

struct Sample {
  std::vector<double> means, variances, labels;
};

// Labels drawn from the model itself with a = 2.5, b = -0.4.
Sample DrawSample(int n, uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const SquashParameters truth{2.5, -0.4};
  Sample sample;
  for (int i = 0; i < n; ++i) {
    sample.means.push_back(2.0 * uniform(generator) - 1.0);
    sample.variances.push_back(0.3 * uniform(generator));
    const double p = truth.Probability(sample.means[i], sample.variances[i]);
    sample.labels.push_back(uniform(generator) < p ? 1.0 : 0.0);
  }
  return sample;
}

TEST(Squash, ProbabilityFollowsTheFormula) {
  EXPECT_EQ((SquashParameters{1.0, 0.0}.Probability(0.0, 3.0)), 0.5);
  // Phi(1) = 0.8413447460685429 with a = 2, b = 0.2, mean 0.6, variance (1.4^2 - 1) / 4.
  EXPECT_NEAR((SquashParameters{2.0, 0.2}.Probability(0.6, 0.24)), 0.8413447460685429, 1e-15);
}

TEST(Squash, LikelihoodHasNoUnderflow) {
  // log Phi(-40) = -804.608442 (Mills' ratio); a plain logarithm of Phi is -infinity.
  EXPECT_NEAR(SquashLogLikelihood({1.0, 0.0}, {-40.0}, {0.0}, {1.0}), -804.6084420137538, 1e-9);
  // Both branches meet: log Phi is smooth over z = -20, where its slope is 20.0498; values of 203
  // are rounded to 3e-14 and the series is cut at 3e-12.
  const double left = SquashLogLikelihood({1.0, 0.0}, {-20.0 - 1e-7}, {0.0}, {1.0});
  const double right = SquashLogLikelihood({1.0, 0.0}, {-20.0 + 1e-7}, {0.0}, {1.0});
  EXPECT_NEAR(right - left, 2e-7 * 20.0498, 1e-11);
}

TEST(FitSquash, FindsTheMaximum) {
  const Sample sample = DrawSample(4000, 7);
  SquashFitOptions options;
  options.log_a_prior_stddev = std::numeric_limits<double>::infinity();
  const auto fit =
      Value(FitSquash(sample.means, sample.variances, sample.labels, {1.0, 0.0}, options));
  EXPECT_FALSE(fit.at_bound);
  // Standard errors of a and b over 4000 points are about 0.1 and 0.05.
  EXPECT_NEAR(fit.parameters.a, 2.5, 0.4);
  EXPECT_NEAR(fit.parameters.b, -0.4, 0.2);
  for (const double da : {-1e-3, 0.0, 1e-3}) {
    for (const double db : {-1e-3, 0.0, 1e-3}) {
      const SquashParameters near{fit.parameters.a + da, fit.parameters.b + db};
      // Newton's last step is under 1e-10: the value is the maximum to rounding of 4000 terms.
      EXPECT_LE(SquashLogLikelihood(near, sample.means, sample.variances, sample.labels),
                fit.log_likelihood + 1e-9);
    }
  }
  const auto from_afar =
      Value(FitSquash(sample.means, sample.variances, sample.labels, {9.0, 4.0}, options));
  EXPECT_NEAR(from_afar.parameters.a, fit.parameters.a, 1e-6);
  EXPECT_NEAR(from_afar.parameters.b, fit.parameters.b, 1e-6);
}

TEST(FitSquash, SoftLabelsWeightBothClasses) {
  // A soft label counts as a share of a point of each class.
  const std::vector<double> means = {-0.9, -0.2, 0.1, 0.8}, variances = {0.1, 0.2, 0.1, 0.3};
  const std::vector<double> labels = {0.1, 0.4, 0.6, 0.85};
  double expected = 0.0;
  for (size_t i = 0; i < 4; ++i) {
    const double p = SquashParameters{1.7, 0.3}.Probability(means[i], variances[i]);
    expected += labels[i] * std::log(p) + (1.0 - labels[i]) * std::log(1.0 - p);
  }
  EXPECT_NEAR(SquashLogLikelihood({1.7, 0.3}, means, variances, labels), expected, 1e-13);
}

TEST(FitSquash, SeparableDataAndOneClassStayInBounds) {
  std::vector<double> means, labels;
  for (int i = 0; i < 100; ++i) {
    means.push_back(i < 50 ? -0.5 : 0.5);
    labels.push_back(i < 50 ? 0.0 : 1.0);
  }
  const std::vector<double> variances(100, 0.01);
  SquashFitOptions options;
  options.log_a_prior_stddev = std::numeric_limits<double>::infinity();
  const auto separable = Value(FitSquash(means, variances, labels, {1.0, 0.0}, options));
  EXPECT_DOUBLE_EQ(separable.parameters.a, 10.0);
  EXPECT_TRUE(separable.at_bound);
  const auto one_class =
      Value(FitSquash(means, variances, std::vector<double>(100, 1.0), {1.0, 0.0}, options));
  EXPECT_GE(one_class.parameters.a, 0.3);
  EXPECT_LE(std::abs(one_class.parameters.b), 5.0);
  // Means that speak against their labels: a stays positive.
  for (double& label : labels) label = 1.0 - label;
  const auto reversed = Value(FitSquash(means, variances, labels, {1.0, 0.0}, options));
  EXPECT_DOUBLE_EQ(reversed.parameters.a, 0.3);
  const auto nothing = Value(FitSquash({}, {}, {}, {50.0, 0.0}));
  EXPECT_DOUBLE_EQ(nothing.parameters.a, 10.0);
}

// The curvature in log a is 1e-26, far below what is added to keep the determinant from zero; a
// gradient of 1e-13 still changes the likelihood by more than its rounding.
TEST(FitSquash, AWeakSignalIsFollowedUphill) {
  SquashFitOptions options;
  options.log_a_prior_stddev = std::numeric_limits<double>::infinity();
  const std::vector<double> variances(4, 0.0), labels = {0.0, 0.0, 1.0, 1.0};
  const auto fit =
      Value(FitSquash({-1e-13, -1e-13, 1e-13, 1e-13}, variances, labels, {1.0, 0.0}, options));
  EXPECT_DOUBLE_EQ(fit.parameters.a, 10.0);
}

TEST(FitSquash, RefusesBadArguments) {
  const auto message = [](std::vector<double> means, std::vector<double> variances,
                          std::vector<double> labels, SquashFitOptions options = {}) {
    const auto fit = FitSquash(means, variances, labels, {1.0, 0.0}, options);
    EXPECT_THAT(fit, IsInvalid());
    return std::string(fit.status().message());
  };
  EXPECT_THAT(message({0.0}, {1.0}, {}), HasSubstr("sizes"));
  EXPECT_THAT(message({0.0, std::nan("")}, {1.0, 1.0}, {0.5, 0.5}), HasSubstr("point 1"));
  EXPECT_THAT(message({0.0}, {-1.0}, {0.5}), HasSubstr("variance -1"));
  EXPECT_THAT(message({0.0}, {1.0}, {1.1}), HasSubstr("label 1.1"));
  SquashFitOptions options;
  options.minimum_a = 0.0;
  EXPECT_THAT(message({0.0}, {1.0}, {0.5}, options), HasSubstr("minimum_a"));
  options = {};
  options.log_a_prior_stddev = std::nan("");
  EXPECT_THAT(message({0.0}, {1.0}, {0.5}, options), HasSubstr("log_a_prior_stddev"));
}

TEST(FitSquash, RefusesAStartThatIsNoParameters) {
  const Sample sample = DrawSample(20, 3);
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  for (const SquashParameters& start :
       {SquashParameters{nan, 0.0}, SquashParameters{1.0, nan}, SquashParameters{infinity, 0.0},
        SquashParameters{0.0, 0.0}, SquashParameters{1.0, -infinity}}) {
    EXPECT_THAT(FitSquash(sample.means, sample.variances, sample.labels, start),
                IsInvalid("start"));
  }
}

}  // namespace
}  // namespace egosieve::gp
