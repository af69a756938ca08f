#include "kernels/covariance/covariance_function.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "kernels/base/prepared_points.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/reference/covariance.h"
#include "tests/kernels/covariance/expressions.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using testing::HasSubstr;

// Points with a duplicate and, for the periodic function, a step of its period.
std::vector<double> SomePoints(int64_t n, int64_t dimension) {
  std::mt19937_64 random = TestRandom();
  std::vector<double> points = RandomPoints(random, n, dimension);
  std::copy_n(points.begin(), dimension, points.begin() + dimension);
  return points;
}

class EveryFunction : public testing::TestWithParam<std::tuple<std::string, int64_t>> {
 protected:
  static constexpr int64_t kCount = 12;
  EveryFunction()
      : dimension_(std::get<1>(GetParam())),
        parameters_(ParametersOf(std::get<0>(GetParam()), dimension_)),
        points_(SomePoints(kCount, dimension_)),
        x_(points_.data(), kCount, dimension_) {}

  RowMajor Gram(const CovarianceParameters& parameters) const {
    RowMajor k(kCount, kCount);
    reference::CovarianceBlock(parameters, x_, x_, false, {k.data(), kCount, kCount});
    return k;
  }

  int64_t dimension_;
  CovarianceParameters parameters_;
  std::vector<double> points_;
  ConstMatrixView<double> x_;
};

TEST_P(EveryFunction, IsACovariance) {
  ASSERT_TRUE(parameters_.Validate().ok()) << parameters_.Validate();
  const RowMajor k = Gram(parameters_);
  EXPECT_EQ(k, RowMajor(k.transpose()));
  const CovarianceDescription& function = parameters_.function.description();
  const double signal = parameters_.signal_stddev * parameters_.signal_stddev;
  for (int64_t i = 0; i < kCount; ++i) {
    // The variance is written apart from the value: two roundings a term and factor, of D of them.
    const double variance =
        signal * function.Variance(parameters_.scales.data(), dimension_, x_.row(i));
    EXPECT_NEAR(k(i, i), variance, 1e-14 * static_cast<double>(dimension_ + 10) * variance);
  }
  // Positive semidefinite: rounding moves an eigenvalue by n eps |K| at most.
  RowMajor moved = k;
  moved.diagonal().array() += 1e-13 * kCount * k.diagonal().maxCoeff();
  EXPECT_EQ(moved.llt().info(), Eigen::Success);
}

TEST_P(EveryFunction, DerivativesAreFiniteDifferences) {
  std::mt19937_64 random = TestRandom();
  RowMajor w(kCount, kCount);
  for (int64_t i = 0; i < kCount; ++i) {
    for (int64_t j = 0; j <= i; ++j) w(i, j) = w(j, i) = Uniform(random, -1.0, 1.0);
  }
  const std::vector<double> gradient =
      reference::CovarianceGradient(parameters_, x_, x_, {w.data(), kCount, kCount}, true);
  ASSERT_EQ(gradient.size(), parameters_.scales.size() + 1);
  const double size = Gram(parameters_).cwiseAbs().sum();
  for (size_t t = 0; t < gradient.size(); ++t) {
    // Five-point rule: its truncation is h^4 / 30 times the fifth derivative by the logarithm,
    // which is 1e5 times k at most (the periodic one goes through 15 radians between two points,
    // and 15^5 is 8e5, where its covariance is a tenth); its rounding eps / h times the sum.
    const double h = 1e-3, offsets[4] = {-2.0 * h, -h, h, 2.0 * h};
    double values[4];
    for (int i = 0; i < 4; ++i) {
      CovarianceParameters moved = parameters_;
      (t < moved.scales.size() ? moved.scales[t] : moved.signal_stddev) *= std::exp(offsets[i]);
      values[i] = Gram(moved).cwiseProduct(w).sum();
    }
    const double difference =
        (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * h);
    EXPECT_NEAR(gradient[t], difference, (1e-12 / 30.0 * 1e5 + 4.4e-16 / h * 4.0) * size)
        << "parameter " << t;
  }
}

TEST_P(EveryFunction, InputDerivativesAreFiniteDifferences) {
  RowMajor w(kCount, kCount), gradient(kCount, dimension_);
  std::mt19937_64 random = TestRandom();
  for (int64_t i = 0; i < w.size(); ++i) w.data()[i] = Uniform(random, -1.0, 1.0);
  // Beside the other points, for some functions have a cusp or a step where two are equal.
  std::vector<double> others = RandomPoints(random, kCount, dimension_);
  for (double& value : others) value += 2.2;
  ASSERT_TRUE(CovarianceInputGradient(parameters_, {others.data(), kCount, dimension_}, x_,
                                      {w.data(), kCount, kCount},
                                      {gradient.data(), kCount, dimension_})
                  .ok());
  const auto sums = [&](int64_t d, double offset) {
    std::vector<double> moved = others;
    for (int64_t i = 0; i < kCount; ++i) moved[i * dimension_ + d] += offset;
    RowMajor k(kCount, kCount);
    reference::CovarianceBlock(parameters_, {moved.data(), kCount, dimension_}, x_, false,
                               {k.data(), kCount, kCount});
    return Eigen::VectorXd(k.cwiseProduct(w).rowwise().sum());
  };
  for (int64_t d = 0; d < dimension_; ++d) {
    // Five-point rule, as above: h^4 / 30 times fifth derivatives of up to (2 pi / 0.8)^5 = 3e4,
    // those of the periodic function.
    const double h = 1e-3;
    const Eigen::VectorXd difference =
        (sums(d, -2.0 * h) - 8.0 * sums(d, -h) + 8.0 * sums(d, h) - sums(d, 2.0 * h)) / (12.0 * h);
    EXPECT_LE((gradient.col(d) - difference).cwiseAbs().maxCoeff(), 1e-6) << "input " << d;
  }
  // f is symmetric: the variance's gradient is twice that of k(x, x') by x at x' = x.
  std::vector<double> of_variance(dimension_);
  PriorVarianceGradient(parameters_, others.data(), of_variance.data());
  const CovarianceDescription& function = parameters_.function.description();
  for (int64_t d = 0; d < dimension_; ++d) {
    const double h = 1e-4, signal = parameters_.signal_stddev * parameters_.signal_stddev;
    std::vector<double> ahead(others.begin(), others.begin() + dimension_), behind = ahead;
    ahead[d] += h;
    behind[d] -= h;
    const double difference =
        signal *
        (function.Variance(parameters_.scales.data(), dimension_, ahead.data()) -
         function.Variance(parameters_.scales.data(), dimension_, behind.data())) /
        (2.0 * h);
    EXPECT_NEAR(of_variance[d], difference, 1e-6) << "input " << d;
  }
}

// Bochner: means of N cosines, whose error is below sqrt(2 log(2 / p) / N) of the mass with
// probability 1 - p (Hoeffding), p = 1e-9 for each of the pairs.
TEST_P(EveryFunction, FrequenciesAreItsSpectralMeasure) {
  const CovarianceDescription& function = parameters_.function.description();
  const double mass = function.SpectralMass(parameters_.scales.data(), dimension_);
  if (mass == 0.0 || dimension_ > 6) return;
  constexpr int kDraws = 20000;
  std::mt19937_64 random = TestRandom();
  std::normal_distribution<double> normal;
  RowMajor sums = RowMajor::Zero(kCount, kCount);
  for (int t = 0; t < kDraws; ++t) {
    Eigen::VectorXd frequency = Eigen::VectorXd::Zero(dimension_);
    function.AddFrequency(
        parameters_.scales.data(), dimension_, [&] { return normal(random); }, frequency.data());
    const Eigen::VectorXd phases =
        Eigen::Map<const RowMajor>(points_.data(), kCount, dimension_) * frequency;
    for (int64_t i = 0; i < kCount; ++i) {
      for (int64_t j = 0; j < kCount; ++j) sums(i, j) += std::cos(phases[i] - phases[j]);
    }
  }
  const double signal = parameters_.signal_stddev * parameters_.signal_stddev;
  const double error = std::sqrt(2.0 * std::log(2e9) / kDraws) * mass;
  EXPECT_LE((sums * (mass / kDraws) - Gram(parameters_) / signal).cwiseAbs().maxCoeff(), error);
}

TEST_P(EveryFunction, HasATextABoundAndAStartForEveryScale) {
  const CovarianceFunction function = parameters_.function;
  EXPECT_EQ(Function(std::string(function.text())), function);
  const CovarianceDescription& description = function.description();
  EXPECT_EQ(&Function(std::string(function.text())).description(), &description);
  const int64_t count = description.ScaleCount(dimension_);
  const int64_t told = description.DimensionOf(count);
  EXPECT_TRUE(told == dimension_ || told == 0);
  for (const ScaleGroup& group : description.scale_groups()) {
    EXPECT_LT(group.lower_log, std::log(group.initial));
    EXPECT_GT(group.upper_log, std::log(group.initial));
  }
}

INSTANTIATE_TEST_SUITE_P(Functions, EveryFunction,
                         testing::Combine(testing::ValuesIn(Expressions()),
                                          testing::Values(1, 6, 32, 100)));
INSTANTIATE_TEST_SUITE_P(Columns, EveryFunction,
                         testing::Combine(testing::Values(kOfColumns), testing::Values(5)));

TEST(CovarianceFunction, ListsEveryFunction) {
  EXPECT_EQ(
      CovarianceFunction::Names(),
      (std::vector<std::string>{"arcsine", "constant", "linear", "matern12", "matern32", "matern52",
                                "periodic", "rational_quadratic", "squared_exponential", "white"}));
}

TEST(CovarianceFunction, ReadsItsGrammar) {
  const auto canonical = [](const char* text) { return std::string(Function(text).text()); };
  EXPECT_EQ(canonical("matern52"), "matern52");
  EXPECT_EQ(canonical(" ( (arcsine) ) "), "arcsine");
  EXPECT_EQ(canonical("linear+constant*white"), "linear + constant * white");
  EXPECT_EQ(canonical("(linear+constant)*white"), "(linear + constant) * white");
  EXPECT_EQ(canonical("isotropic( linear )"), "isotropic(linear)");
  EXPECT_EQ(canonical("(matern52) [ 0 , 1 ]"), "matern52[0,1]");
  EXPECT_EQ(canonical("(matern52[0, 1])"), "matern52[0,1]");
  EXPECT_EQ(canonical("isotropic(linear)[1, 3, 4, 5:8, 9]"), "isotropic(linear)[1,3:8,9]");
  EXPECT_EQ(canonical("(linear[2] + constant)*white"), "(linear[2] + constant) * white");
  EXPECT_EQ(Function("arcsine"), CovarianceFunction::kArcsine);
  EXPECT_NE(Function("matern52"), CovarianceFunction::kArcsine);
}

TEST(CovarianceFunction, SaysWhatItCannotRead) {
  const auto message = [](const std::string& text) {
    const auto function = CovarianceFunction::Parse(text);
    EXPECT_THAT(function, IsInvalid()) << text;
    return std::string(function.status().message());
  };
  EXPECT_THAT(message("matern53"), HasSubstr("character 1; functions are arcsine, constant"));
  EXPECT_THAT(message(""), HasSubstr("expected a covariance function"));
  EXPECT_THAT(message("linear + "), HasSubstr("expected a covariance function at character 10"));
  EXPECT_THAT(message("(linear"), HasSubstr("expected ')'"));
  EXPECT_THAT(message("linear white"), HasSubstr("expected '+' or '*'"));
  EXPECT_THAT(message("isotropic linear"), HasSubstr("expected '(' after isotropic"));
  for (const char* columns :
       {"[]", "[-1]", "[1, 0]", "[0, 0]", "[2:2]", "[0:]", "[0:257]", "[9999]"}) {
    EXPECT_THAT(message("linear" + std::string(columns)), HasSubstr("expected")) << columns;
  }
  EXPECT_THAT(message("linear[256]"), HasSubstr("expected increasing columns"));
  EXPECT_THAT(message("linear[0"), HasSubstr("expected ']'"));
  EXPECT_THAT(message("(linear[0] + white)[1]"), HasSubstr("without columns before '['"));
  EXPECT_THAT(message("isotropic(linear[0])"), HasSubstr("columns behind isotropic(...)"));
  EXPECT_THAT(message(std::string(100, '(') + "linear"), HasSubstr("parentheses"));
}

// Derivatives and devices: EveryFunction and OnTheDevice, of compositions with columns.
TEST(Columns, FactorTheSquaredExponential) {
  std::mt19937_64 random = TestRandom();
  const std::vector<double> points = RandomPoints(random, 20, 3);
  const ConstMatrixView<double> x(points.data(), 20, 3);
  CovarianceParameters all = ParametersOf("squared_exponential[0,2]", 3);
  CovarianceParameters apart = ParametersOf("squared_exponential[0] * squared_exponential[2]", 3);
  all.scales = apart.scales = {0.7, 1.9};
  RowMajor k(20, 20), product(20, 20);
  reference::CovarianceBlock(all, x, x, false, {k.data(), 20, 20});
  reference::CovarianceBlock(apart, x, x, false, {product.data(), 20, 20});
  // Exponents of up to 20 are rounded to 10 eps of theirs, that is to 200 eps of k.
  EXPECT_TRUE(k.isApprox(product, 200 * 2.2e-16));
  EXPECT_EQ(all.function.description().ScaleCount(3), 2);
  // The other column does not matter, and two inputs alone give the same.
  std::vector<double> two;
  for (int64_t i = 0; i < 20; ++i) two.insert(two.end(), {points[3 * i], points[3 * i + 2]});
  CovarianceParameters plain = ParametersOf("squared_exponential", 2);
  plain.scales = all.scales;
  reference::CovarianceBlock(plain, {two.data(), 20, 2}, {two.data(), 20, 2}, false,
                             {product.data(), 20, 20});
  EXPECT_EQ(k, product);
}

TEST(Columns, AreWithinTheInputs) {
  CovarianceParameters parameters = ParametersOf("matern52 + constant[4]", 5);
  EXPECT_TRUE(parameters.Validate().ok());
  parameters = ParametersOf("matern52 + constant[4]", 4);
  EXPECT_THAT(parameters.Validate(), IsInvalid("has column 4; there are 4 inputs"));
}

TEST(CovarianceParameters, ScalesAreCounted) {
  CovarianceParameters parameters = ParametersOf("isotropic(matern52)", 3);
  EXPECT_TRUE(parameters.Validate().ok());
  parameters.dimension = 0;  // one scale does not tell
  EXPECT_THAT(parameters.Validate().message(), HasSubstr("input dimension 0"));
  parameters = ParametersOf("matern52", 3);
  parameters.dimension = 2;
  EXPECT_THAT(std::string(parameters.Validate().message()),
              HasSubstr("scales: 3 values; matern52 of 2 inputs has 2"));
}

// What depends on differences alone does so wherever the inputs lie: 2^40 and 2^40 + 3/4 are exact,
// but a period of 1 seen from zero would leave an angle's digits behind the point.
TEST(PointPreparation, PeriodsFarFromZeroKeepTheirPhase) {
  CovarianceParameters parameters = ParametersOf("periodic", 1);
  parameters.scales = {1.0, 1.3};
  const auto value = [&](double origin) {
    const double x[2] = {origin, origin + 0.75};
    const PointPreparation preparation(parameters, CentreOf({x, 2, 1}));
    double a[3], b[3];
    preparation.Prepare(&x[0], a, 1);
    preparation.Prepare(&x[1], b, 1);
    double square = 0.0;
    for (int i = 0; i < 2; ++i) square += (a[i] - b[i]) * (a[i] - b[i]);
    return square;
  };
  EXPECT_NEAR(value(0x1p40), value(0.0), 1e-12);
}

}  // namespace
}  // namespace egosieve::kernels
