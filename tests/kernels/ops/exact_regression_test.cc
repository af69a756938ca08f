// Regression on the device against its definition in float64 by Eigen, with covariances of the
// reference.
#include "kernels/ops/exact_regression.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "kernels/reference/covariance.h"
#include "kernels/runtime/context.h"
#include "tests/kernels/covariance/expressions.h"
#include "tests/kernels/failing_calls.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Data {
  Data(int64_t n, int64_t dimension, int64_t outputs)
      : n(n), dimension(dimension), outputs(outputs) {
    std::mt19937_64 random = TestRandom();
    points = RandomPoints(random, n, dimension);
    targets = RandomPoints(random, n, outputs);
    for (int64_t i = 0; i < n; ++i) variances.push_back(Uniform(random, 0.0, 0.5));
  }
  ConstMatrixView<double> x() const { return {points.data(), n, dimension}; }
  ConstMatrixView<double> y() const { return {targets.data(), n, outputs}; }

  int64_t n, dimension, outputs;
  std::vector<double> points, targets, variances;
};

constexpr double kNoise = 0.2;

// K + diag(noise), by the reference.
Matrix NoisyCovariance(const CovarianceParameters& parameters, const Data& data) {
  Matrix covariance(data.n, data.n);
  reference::CovarianceBlock(parameters, data.x(), data.x(), false,
                             {covariance.data(), data.n, data.n});
  for (int64_t i = 0; i < data.n; ++i) covariance(i, i) += kNoise + data.variances[i];
  return covariance;
}

void ExpectTheDefinition(const std::string& function, const Data& data) {
  SCOPED_TRACE(function);
  const CovarianceParameters parameters = ParametersOf(function, data.dimension);
  const auto actual = Value(RegressOnDevice(*TestContext(), parameters, data.x(), data.y(), kNoise,
                                            data.variances, /*with_gradient=*/true));
  ASSERT_EQ(actual.bad_row, -1);
  const int64_t n = data.n, k = data.outputs;
  const Matrix covariance = NoisyCovariance(parameters, data);
  const Eigen::LLT<Matrix> llt(covariance);
  const Matrix l = llt.matrixL();
  const Eigen::Map<const Matrix> y(data.targets.data(), n, k);
  const Matrix alpha = llt.solve(y), inverse = llt.solve(Matrix::Identity(n, n));
  const Matrix weights = alpha * alpha.transpose() - static_cast<double>(k) * inverse;
  const std::vector<double> gradient =
      reference::CovarianceGradient(parameters, data.x(), data.x(), {weights.data(), n, n}, true);
  // Rounding errors: the matrix's condition is at most its norm over the noise.
  const double relative = 100.0 * static_cast<double>(n) * std::numeric_limits<double>::epsilon() *
                          covariance.norm() / kNoise;
  const Eigen::Map<const Matrix> solved(actual.alpha.data(), n, k);
  EXPECT_LE((solved - alpha).norm(), relative * alpha.norm());
  EXPECT_NEAR(actual.fit, (y.array() * alpha.array()).sum(), relative * y.norm() * alpha.norm());
  EXPECT_NEAR(actual.half_log_determinant, l.diagonal().array().log().sum(),
              relative * static_cast<double>(n));
  EXPECT_NEAR(actual.trace, weights.trace(), relative * weights.norm() * std::sqrt(n));
  ASSERT_EQ(actual.gradient.size(), gradient.size());
  for (size_t t = 0; t < gradient.size(); ++t) {
    EXPECT_NEAR(actual.gradient[t], gradient[t], relative * weights.norm() * covariance.norm())
        << t;
  }
}

TEST(ExactRegression, IsTheDefinition) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no device";
  ExpectTheDefinition("matern52", Data(1, 2, 1));
  ExpectTheDefinition("matern52", Data(130, 6, 1));
  ExpectTheDefinition("arcsine", Data(70, 3, 4));
  ExpectTheDefinition(kOfColumns, Data(50, 5, 1));
  ExpectTheDefinition("isotropic(rational_quadratic) + white", Data(65, 32, 2));
}

TEST(ExactRegression, WithoutGradientGivesTheSame) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no device";
  const Data data(70, 3, 2);
  const CovarianceParameters parameters = ParametersOf("matern32", 3);
  const auto with =
      Value(RegressOnDevice(*TestContext(), parameters, data.x(), data.y(), kNoise, {}, true));
  const auto without =
      Value(RegressOnDevice(*TestContext(), parameters, data.x(), data.y(), kNoise, {}, false));
  EXPECT_EQ(with.alpha, without.alpha);
  EXPECT_EQ(with.fit, without.fit);
  EXPECT_EQ(with.half_log_determinant, without.half_log_determinant);
  EXPECT_TRUE(without.gradient.empty());
}

// A point twice and no noise.
TEST(ExactRegression, NamesTheRowThatIsRefused) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no device";
  Data data(80, 2, 1);
  std::copy_n(&data.points[2 * 5], 2, &data.points[2 * 71]);
  const auto result = Value(RegressOnDevice(*TestContext(), ParametersOf("matern12", 2), data.x(),
                                            data.y(), 0.0, {}, true));
  EXPECT_EQ(result.bad_row, 71);
}

// n^2 values stay where they are.
TEST(ExactRegression, NothingSquareCrosses) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no device";
  const auto bytes = [](int64_t n) {
    const Data data(n, 2, 1);
    TakeHostBytes();
    EXPECT_TRUE(RegressOnDevice(*TestContext(), ParametersOf("matern52", 2), data.x(), data.y(),
                                kNoise, {}, true)
                    .ok());
    return TakeHostBytes();
  };
  bytes(64);  // compiles
  // Points as rows and as columns, targets and noise: 2 D + 2 values a point, and columns padded to
  // a vector of at most 16.
  const int64_t of_a_point = (2 * 2 + 2) * static_cast<int64_t>(sizeof(double));
  const int64_t padding = 16 * 2 * static_cast<int64_t>(sizeof(double));
  EXPECT_LE(bytes(64), 64 * of_a_point + padding);
  EXPECT_LE(bytes(256), 256 * of_a_point + padding);
  EXPECT_GE(bytes(256), 256 * of_a_point);
}

// Around a tile, and around a band of the download.
TEST(ExactRegression, TheFactorComesToTheHost) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no device";
  for (const int64_t n : {1, 63, 64, 65, 256, 257, 300}) {
    SCOPED_TRACE(n);
    const Data data(n, 3, 1);
    const CovarianceParameters parameters = ParametersOf("matern52", 3);
    GuardedMatrix<double> out(n, n, 3);
    const auto bad = Value(FactorizeOnDevice(*TestContext(), parameters, data.x(), kNoise,
                                             data.variances, out.view()));
    EXPECT_EQ(bad, -1);
    EXPECT_TRUE(out.guards_intact());
    const Matrix covariance = NoisyCovariance(parameters, data);
    Matrix l = Matrix::Zero(n, n);
    for (int64_t i = 0; i < n; ++i) {
      for (int64_t j = 0; j < n; ++j) {
        if (j <= i) l(i, j) = out(i, j);
        if (j > i) {
          ASSERT_EQ(out(i, j), GuardedMatrix<double>::kCanary) << i << ", " << j;
        }
      }
    }
    // Backward error: n eps |K| for the factor, 20 for inverted blocks, whose condition is that of
    // K.
    EXPECT_LE(
        (l * l.transpose() - covariance).cwiseAbs().maxCoeff(),
        20.0 * static_cast<double>(n) * std::numeric_limits<double>::epsilon() * covariance.norm());
  }
}

TEST(ExactRegression, ARefusedFactorIsNotWritten) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no device";
  Data data(80, 2, 1);
  std::copy_n(&data.points[2 * 5], 2, &data.points[2 * 71]);
  GuardedMatrix<double> out(80, 80);
  const CovarianceParameters parameters = ParametersOf("matern12", 2);
  const auto bad =
      Value(FactorizeOnDevice(*TestContext(), parameters, data.x(), 0.0, {}, out.view()));
  EXPECT_EQ(bad, 71);
  EXPECT_TRUE(out.untouched());
  GuardedMatrix<double> small(79, 80);
  EXPECT_THAT(FactorizeOnDevice(*TestContext(), parameters, data.x(), 0.1, {}, small.view()),
              IsInvalid());
  EXPECT_TRUE(small.untouched());
}

TEST(ExactRegression, RefusesWhatItCannotTake) {
  const Data data(10, 2, 1);
  const CovarianceParameters parameters = ParametersOf("matern52", 2);
  const auto code = [&](ConstMatrixView<double> x, ConstMatrixView<double> y, double noise,
                        absl::Span<const double> variances) {
    return RegressOnDevice(*TestContext(), parameters, x, y, noise, variances, false)
        .status()
        .code();
  };
  const auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_EQ(code({data.points.data(), 0, 2}, {data.targets.data(), 0, 1}, 0.1, {}), kInvalid);
  EXPECT_EQ(code({data.points.data(), 5, 3}, {data.targets.data(), 5, 1}, 0.1, {}), kInvalid);
  EXPECT_EQ(code(data.x(), {data.targets.data(), 9, 1}, 0.1, {}), kInvalid);
  EXPECT_EQ(code(data.x(), data.y(), 0.1, {1.0}), kInvalid);
  const auto context = Value(OpenContext({.float64 = false}));
  EXPECT_EQ(
      RegressOnDevice(*context, parameters, data.x(), data.y(), 0.1, {}, false).status().code(),
      absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace egosieve::kernels
