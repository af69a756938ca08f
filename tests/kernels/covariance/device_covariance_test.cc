// Every covariance function on the device against the float64 reference: values, derivatives,
// posterior.
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "kernels/base/prepared_points.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/reference/covariance.h"
#include "kernels/reference/dense_posterior.h"
#include "tests/kernels/covariance/expressions.h"
#include "tests/kernels/float32_covariances.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

constexpr int64_t kCount = 21;    // ends inside a vector
constexpr int64_t kQueries = 37;  // likewise

class OnTheDevice : public testing::TestWithParam<std::tuple<std::string, int64_t>> {
 protected:
  OnTheDevice()
      : random_(TestRandom()),
        dimension_(std::get<1>(GetParam())),
        parameters_(ParametersOf(std::get<0>(GetParam()), dimension_)),
        points_(RandomPoints(random_, kCount, dimension_)),
        x_(points_.data(), kCount, dimension_) {
    std::copy_n(points_.begin(), dimension_, points_.begin() + dimension_);
  }

  // A covariance's error in roundings: |p| + |p'| of them from rounding the points, by a slope of 2
  // at most (a product of two functions), and 60 from the arithmetic; times the largest variance.
  double Roundings() const {
    const PointPreparation preparation(parameters_);
    std::vector<double> point(preparation.width());
    double norm = 0.0, variance = 1.0;
    for (int64_t i = 0; i < kCount; ++i) {
      preparation.Prepare(x_.row(i), point.data(), 1);
      double square = 0.0;
      for (const double value : point) square += value * value;
      norm = std::max(norm, std::sqrt(square));
      variance = std::max(variance, parameters_.function.description().Variance(
                                        parameters_.scales.data(), dimension_, x_.row(i)));
    }
    return (4.0 * norm + 60.0) * variance;
  }

  // k(i, j): the covariance of points i and j.
  template <typename Matrix>
  void ExpectReferencesMatrix(const Matrix& k, double unit_roundoff) {
    GuardedMatrix<double> expected(kCount, kCount, 0);
    reference::CovarianceBlock(parameters_, x_, x_, false, expected.view());
    const double signal = parameters_.signal_stddev * parameters_.signal_stddev;
    for (int64_t i = 0; i < kCount; ++i) {
      for (int64_t j = 0; j < kCount; ++j) {
        ASSERT_NEAR(k(i, j), expected(i, j), Roundings() * unit_roundoff * signal)
            << i << ", " << j;
      }
    }
  }

  std::mt19937_64 random_;
  int64_t dimension_;
  CovarianceParameters parameters_;
  std::vector<double> points_;
  ConstMatrixView<double> x_;
};

TEST_P(OnTheDevice, ValuesAreTheReferences) {
  const std::vector<float> narrow = Float32Covariances(TestContext(), parameters_, x_, x_);
  ExpectReferencesMatrix(ConstMatrixView<float>(narrow.data(), kCount, kCount),
                         std::ldexp(1.0, -24));
  GuardedMatrix<double> wide(kCount, kCount, 3);
  ASSERT_EQ(CrossCovariance(*TestContext(), parameters_, x_, x_, wide.view()), absl::OkStatus());
  EXPECT_TRUE(wide.guards_intact());
  ExpectReferencesMatrix(wide, std::ldexp(1.0, -53));
}

TEST_P(OnTheDevice, DerivativesAreTheReferences) {
  std::vector<double> w(kCount * kCount);
  for (double& weight : w) weight = Uniform(random_, -1.0, 1.0);
  const ConstMatrixView<double> weights(w.data(), kCount, kCount);
  const auto actual = Value(CovarianceGradient(*TestContext(), parameters_, x_, weights));
  const std::vector<double> expected =
      reference::CovarianceGradient(parameters_, x_, x_, weights, true);
  ASSERT_EQ(actual.size(), expected.size());
  // Some hundred roundings in each of the n^2 terms, which are of the order of the variance; the
  // derivative of Matern 1/2 divides by the distance.
  const double tolerance = 1e3 * kCount * kCount * Roundings() * std::ldexp(1.0, -53);
  for (size_t t = 0; t < expected.size(); ++t) {
    EXPECT_NEAR(actual[t], expected[t], tolerance) << "parameter " << t;
  }
}

TEST_P(OnTheDevice, PosteriorIsTheReferences) {
  const double noise = 0.5;
  const Problem problem = MakeProblem(random_, parameters_, 50, noise);
  const PosteriorModel model = problem.model(FactorKind::kCholesky);
  const auto posterior = Value(DensePosterior::Create(TestContext(), model));
  std::vector<float> queries(kQueries * dimension_);
  for (float& value : queries) value = static_cast<float>(Uniform(random_, -1.0, 1.0));
  const ConstMatrixView<float> at(queries.data(), kQueries, dimension_);
  std::vector<float> mean(kQueries), variance(kQueries);
  ASSERT_TRUE(posterior->Evaluate(at, {mean.data(), variance.data()}).ok());
  std::vector<double> means(kQueries), variances(kQueries);
  reference::DensePosterior(model).Evaluate(at, means.data(), variances.data(),
                                            static_cast<double*>(nullptr));
  // As tests/kernels/test_data.h's bounds, with this function's own roundings of a covariance e:
  // e sigma_f^2 |alpha|_1 for the mean, 2 |v| sqrt(n) e sigma_f^2 / sigma_n for the variance.
  const double signal = parameters_.signal_stddev * parameters_.signal_stddev;
  const double error = signal * Roundings() * std::ldexp(1.0, -24);
  double alpha = 0.0;
  for (const double value : problem.alpha) alpha += std::abs(value);
  const double prior = signal * Roundings() / 60.0;
  for (int64_t q = 0; q < kQueries; ++q) {
    EXPECT_NEAR(mean[q], means[q], error * alpha);
    EXPECT_NEAR(variance[q], variances[q],
                error + 4.0 * std::sqrt(prior) * std::sqrt(50.0) * error / noise);
  }
}

std::string NameOf(const testing::TestParamInfo<std::tuple<std::string, int64_t>>& info) {
  std::string name;
  for (const char c : std::get<0>(info.param)) {
    if (std::isalnum(static_cast<unsigned char>(c))) name.push_back(c);
    if (c == '+') name += "Plus";
    if (c == '*') name += "Times";
  }
  return name + "Of" + std::to_string(std::get<1>(info.param));
}

INSTANTIATE_TEST_SUITE_P(Functions, OnTheDevice,
                         testing::Combine(testing::ValuesIn(CovarianceFunction::Names()),
                                          testing::Values(6)),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(Compositions, OnTheDevice,
                         testing::Combine(testing::ValuesIn(Compositions()), testing::Values(1)),
                         NameOf);
// Loops over 100 values are not unrolled; those over 32 are, which takes long to compile.
INSTANTIATE_TEST_SUITE_P(ManyInputs, OnTheDevice,
                         testing::Combine(testing::ValuesIn(CovarianceFunction::Names()),
                                          testing::Values(100)),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(ManyInputsOfASum, OnTheDevice,
                         testing::Combine(testing::Values("matern52 + linear"),
                                          testing::Values(32, 100)),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(Columns, OnTheDevice,
                         testing::Combine(testing::Values(kOfColumns), testing::Values(5)), NameOf);
INSTANTIATE_TEST_SUITE_P(UnrolledInputs, OnTheDevice,
                         testing::Combine(testing::Values("arcsine"), testing::Values(32)), NameOf);

// Between three places, with unit scale and deviation.
std::vector<float> UnitCovariances(const std::string& name, const double (&x)[3]) {
  CovarianceParameters parameters = ParametersOf(name, 1);
  parameters.scales = {1.0};
  parameters.signal_stddev = 1.0;
  return Float32Covariances(TestContext(), parameters, {x, 3, 1}, {x, 3, 1});
}

// Inputs far from zero: the distance keeps its digits, since a centre is taken away first.
TEST(DeviceCovariance, IsAccurateFarFromZero) {
  const double x[3] = {4000.0, 4000.7, 4001.9};
  const std::vector<float> k = UnitCovariances("squared_exponential", x);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      EXPECT_NEAR(k[3 * i + j], std::exp(-0.5 * (x[i] - x[j]) * (x[i] - x[j])), 2e-6);
    }
  }
}

// At distances whose square float32 cannot hold, too.
TEST(DeviceCovariance, OfStationaryFunctionsVanishesFarAway) {
  for (const char* name : {"squared_exponential", "matern12", "matern32", "matern52"}) {
    const std::vector<float> k = UnitCovariances(name, {0.0, 1e19, 1e30});
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) EXPECT_EQ(k[3 * i + j], i == j ? 1.0f : 0.0f) << name;
    }
  }
}

}  // namespace
}  // namespace egosieve::kernels
