#include "kernels/ops/covariance_gradient.h"

#include <cmath>
#include <limits>

#include "gtest/gtest.h"
#include "kernels/reference/covariance.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

// A symmetric matrix of which only the lower triangle is filled; NaN above it would show if it were
// read.
GuardedMatrix<double> LowerWeights(std::mt19937_64& random, int64_t n) {
  GuardedMatrix<double> w(n, n, 3);
  for (int64_t i = 0; i < n; ++i) {
    for (int64_t j = 0; j < n; ++j) {
      w.view()(i, j) =
          j <= i ? Uniform(random, -1.0, 1.0) : std::numeric_limits<double>::quiet_NaN();
    }
  }
  return w;
}

// sum_ij W_ij k(x_i, x_j) in long double.
long double WeightedSum(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                        ConstMatrixView<double> w) {
  long double sum = 0;
  for (int64_t i = 0; i < x.rows; ++i) {
    for (int64_t j = 0; j <= i; ++j) {
      sum += (i == j ? 1 : 2) * w(i, j) * ExactCovariance(parameters, x.row(i), x.row(j));
    }
  }
  return sum;
}

std::vector<CovarianceParameters> Covariances() {
  return {ArcsineParameters({1.0, 1.5, 0.3, 4.0}, 1.3),
          ArcsineParameters({0.05, 30.0, 5.0, 0.2}, 0.7),
          SquaredExponentialParameters({0.5, 1.0, 3.0}, 1.2)};
}

// The exponent of a parameter t: scales, then sigma_f.
void ScaleParameter(CovarianceParameters& parameters, size_t t, double factor) {
  (t < parameters.scales.size() ? parameters.scales[t] : parameters.signal_stddev) *= factor;
}

TEST(CovarianceGradient, EqualsCentralDifferencesOfTheExactSum) {
  std::mt19937_64 random = TestRandom();
  const int64_t n = 21;
  for (const CovarianceParameters& parameters : Covariances()) {
    std::vector<double> points = RandomPoints(random, n, 3);
    std::copy_n(points.begin(), 3, points.begin() + 9);  // duplicates
    const ConstMatrixView<double> x(points.data(), n, 3);
    GuardedMatrix<double> w = LowerWeights(random, n);
    const auto gradient = Value(CovarianceGradient(*TestContext(), parameters, x, w.view()));
    ASSERT_EQ(gradient.size(), parameters.scales.size() + 1);
    for (size_t t = 0; t < gradient.size(); ++t) {
      // The difference's own error: step^2 / 6 times a third derivative of at most 8 k a pair, and
      // 1e-19 / step.
      const double step = 1e-5;
      CovarianceParameters above = parameters;
      CovarianceParameters below = parameters;
      ScaleParameter(above, t, std::exp(step));
      ScaleParameter(below, t, std::exp(-step));
      const long double difference =
          (WeightedSum(above, x, w.view()) - WeightedSum(below, x, w.view())) / (2 * step);
      EXPECT_NEAR(
          gradient[t], static_cast<double>(difference),
          8 * 1.6 * n * n * step * step / 6 * parameters.signal_stddev * parameters.signal_stddev)
          << "parameter " << t;
    }
  }
}

TEST(CovarianceGradient, AgreesWithTheReferenceAtSizesAroundEveryBlock) {
  std::mt19937_64 random = TestRandom();
  for (const CovarianceParameters& parameters : Covariances()) {
    for (const int64_t n : {0, 1, 3, 4, 5, 7, 8, 9, 16, 17, 63, 130}) {
      const std::vector<double> points = RandomPoints(random, n, 3);
      const ConstMatrixView<double> x(points.data(), n, 3);
      GuardedMatrix<double> w = LowerWeights(random, n);
      const auto gradient = Value(CovarianceGradient(*TestContext(), parameters, x, w.view()));
      const std::vector<double> expected = reference::CovarianceGradient(parameters, x, w.view());
      // n^2 terms below 2 sigma_f^2 pi / 2 in size, each within 32 roundings.
      const double tolerance = 1e-300 + 32 * std::ldexp(1.0, -53) * n * n * 3.2 *
                                            parameters.signal_stddev * parameters.signal_stddev;
      for (size_t t = 0; t < expected.size(); ++t) {
        EXPECT_NEAR(gradient[t], expected[t], tolerance) << "parameter " << t << ", n = " << n;
      }
    }
  }
}

// Between two sets that are one, with a symmetric matrix, it is the gradient of one.
TEST(CrossCovarianceGradient, IsTheGradientOfOneSetAndAgreesWithTheReference) {
  std::mt19937_64 random = TestRandom();
  for (const CovarianceParameters& parameters : Covariances()) {
    for (const auto& [n, m] :
         {std::pair<int64_t, int64_t>{0, 3}, {5, 0}, {1, 1}, {7, 9}, {8, 16}, {63, 17}, {4, 130}}) {
      const std::vector<double> a = RandomPoints(random, n, 3), b = RandomPoints(random, m, 3);
      GuardedMatrix<double> w(n, m, 3);
      for (int64_t i = 0; i < n; ++i) {
        for (int64_t j = 0; j < m; ++j) w.view()(i, j) = Uniform(random, -1.0, 1.0);
      }
      const ConstMatrixView<double> x(a.data(), n, 3), z(b.data(), m, 3);
      const auto gradient =
          Value(CrossCovarianceGradient(*TestContext(), parameters, x, z, w.view()));
      const std::vector<double> expected =
          reference::CrossCovarianceGradient(parameters, x, z, w.view());
      const double tolerance = 1e-300 + 32 * std::ldexp(1.0, -53) * n * m * 3.2 *
                                            parameters.signal_stddev * parameters.signal_stddev;
      for (size_t t = 0; t < expected.size(); ++t) {
        EXPECT_NEAR(gradient[t], expected[t], tolerance) << t << " of " << n << " x " << m;
      }
    }
    const std::vector<double> points = RandomPoints(random, 30, 3);
    const ConstMatrixView<double> x(points.data(), 30, 3);
    GuardedMatrix<double> w = LowerWeights(random, 30);
    const auto expected = CovarianceGradient(*TestContext(), parameters, x, w.view());
    std::vector<double> diagonal;
    for (int64_t i = 0; i < 30; ++i) {
      for (int64_t j = 0; j < i; ++j) w.view()(j, i) = w.view()(i, j);
      diagonal.push_back(w.view()(i, i));
    }
    const auto whole = Value(CrossCovarianceGradient(*TestContext(), parameters, x, x, w.view()));
    for (int64_t i = 0; i < 30; ++i) w.view()(i, i) = 0.0;
    const auto beside = Value(CrossCovarianceGradient(*TestContext(), parameters, x, x, w.view()));
    const auto variances = Value(VarianceGradient(parameters, x, diagonal));
    for (size_t t = 0; t < expected->size(); ++t) {
      EXPECT_NEAR(whole[t], (*expected)[t], 1e-11);
      EXPECT_NEAR(beside[t] + variances[t], (*expected)[t], 1e-11);
    }
    EXPECT_THAT(
        CrossCovarianceGradient(*TestContext(), parameters, x, x.rows_between(0, 9), w.view()),
        IsInvalid());
    EXPECT_THAT(VarianceGradient(parameters, x, {1.0}), IsInvalid());
  }
}

TEST(CovarianceGradient, DevicesWithoutFloat64LeaveItToTheHost) {
  std::mt19937_64 random = TestRandom();
  ContextOptions options;
  options.float64 = false;
  const auto context = Value(OpenContext(options));
  const std::vector<double> points = RandomPoints(random, 30, 3);
  GuardedMatrix<double> w = LowerWeights(random, 30);
  for (const CovarianceParameters& parameters : Covariances()) {
    const ConstMatrixView<double> x(points.data(), 30, 3);
    const auto gradient = Value(CovarianceGradient(*context, parameters, x, w.view()));
    EXPECT_EQ(gradient, reference::CovarianceGradient(parameters, x, w.view()));
  }
}

TEST(CovarianceGradient, IsTheSameEveryTime) {
  std::mt19937_64 random = TestRandom();
  const std::vector<double> points = RandomPoints(random, 200, 3);
  GuardedMatrix<double> w = LowerWeights(random, 200);
  const CovarianceParameters parameters = ArcsineParameters({1, 1, 1, 1});
  const auto first =
      Value(CovarianceGradient(*TestContext(), parameters, {points.data(), 200, 3}, w.view()));
  for (int repeat = 0; repeat < 5; ++repeat) {
    EXPECT_EQ(*CovarianceGradient(*TestContext(), parameters, {points.data(), 200, 3}, w.view()),
              first);
  }
}

TEST(CovarianceGradient, BadArgumentsAreNamed) {
  std::mt19937_64 random = TestRandom();
  const std::vector<double> points = RandomPoints(random, 10, 3);
  GuardedMatrix<double> w = LowerWeights(random, 10);
  const CovarianceParameters parameters = ArcsineParameters({1, 1, 1, 1});
  const ConstMatrixView<double> x(points.data(), 10, 3);
  EXPECT_FALSE(
      CovarianceGradient(*TestContext(), parameters, {points.data(), 9, 3}, w.view()).ok());
  EXPECT_FALSE(
      CovarianceGradient(*TestContext(), ArcsineParameters({1, 1, 0, 1}), x, w.view()).ok());
  for (const auto& [scales, message] :
       {std::pair{std::vector<double>{1.0}, "dimension 0"},
        {std::vector<double>(258, 1.0), "dimension 257"},
        {std::vector<double>{1.0, -2.0, 1.0, 1.0}, "scales[1] = -2"}}) {
    EXPECT_THAT(CovarianceGradient(*TestContext(), ArcsineParameters(scales), x, w.view()),
                IsInvalid(message));
  }
  w.view()(7, 2) = INFINITY;
  EXPECT_THAT(CovarianceGradient(*TestContext(), parameters, x, w.view()), IsInvalid("row 7 of w"));
}

}  // namespace
}  // namespace egosieve::kernels
