#include "kernels/ops/covariance_matrix.h"

#include <cmath>
#include <limits>

#include "kernels/reference/covariance.h"
#include "tests/kernels/float32_covariances.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

// Pairs of points from which float32 arithmetic has something to lose: random, equal, nearly equal,
// parallel (in x~, so far out) and nearly antipodal ones.
std::vector<double> AwkwardPoints(std::mt19937_64& random, int64_t dimension) {
  std::vector<double> points = RandomPoints(random, 40, dimension);
  const auto append = [&](int64_t source, double factor, double shift) {
    for (int64_t d = 0; d < dimension; ++d) {
      points.push_back(std::clamp(
          points[source * dimension + d] * factor + shift * Uniform(random, -1, 1), -1.0, 1.0));
    }
  };
  for (int64_t i = 0; i < 12; ++i) {
    append(i, 1.0, 0.0);
    for (const double shift : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8}) {
      append(i, 1.0, shift);
      append(i, -1.0, shift);
    }
    append(i, -1.0, 0.0);
    append(i, 0.5, 0.0);
    append(i, -0.25, 0.0);
  }
  return points;
}

std::vector<CovarianceParameters> ArcsineFamilies() {
  std::vector<CovarianceParameters> families;
  for (const double weight : {0.05, 0.3, 1.0, 4.0, 30.0, 200.0, 1000.0}) {
    families.push_back(ArcsineParameters(std::vector<double>(7, weight)));
  }
  families.push_back(ArcsineParameters({0.05, 1000, 1000, 1000, 1000, 1000, 1000}));
  families.push_back(ArcsineParameters({1000, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05}));
  families.push_back(ArcsineParameters({0.05, 0.3, 1000, 4, 30, 200, 0.1}, 2.5));
  families.push_back(ArcsineParameters({1000, 1, 0.05, 100, 10, 0.5, 1000}, 0.2));
  return families;
}

// Of the points' covariances k(i, j), over sigma_f^2.
template <typename Matrix>
double WorstError(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                  const Matrix& k) {
  double worst = 0.0;
  for (int64_t i = 0; i < x.rows; ++i) {
    for (int64_t j = 0; j < x.rows; ++j) {
      const long double exact = ExactCovariance(parameters, x.row(i), x.row(j));
      const double error = static_cast<double>(std::abs(k(i, j) - exact));
      if (!(error <= worst)) worst = error;
    }
  }
  return worst / (parameters.signal_stddev * parameters.signal_stddev);
}

double WorstFloat32Error(const CovarianceParameters& parameters, ConstMatrixView<double> x) {
  const std::vector<float> k = Float32Covariances(TestContext(), parameters, x, x);
  return WorstError(parameters, x, ConstMatrixView<float>(k.data(), x.rows, x.rows));
}

double WorstFloat64Error(const CovarianceParameters& parameters, ConstMatrixView<double> x) {
  GuardedMatrix<double> k(x.rows, x.rows, 3);
  EXPECT_EQ(CrossCovariance(*TestContext(), parameters, x, x, k.view()), absl::OkStatus());
  EXPECT_TRUE(k.guards_intact());
  return WorstError(parameters, x, k);
}

TEST(CovarianceMatrix, ArcsineInFloatIsWithinOneMillionthOnAwkwardInputs) {
  std::mt19937_64 random = TestRandom();
  const std::vector<double> points = AwkwardPoints(random, 6);
  const ConstMatrixView<double> x(points.data(), static_cast<int64_t>(points.size()) / 6, 6);
  for (const CovarianceParameters& parameters : ArcsineFamilies()) {
    EXPECT_LE(WorstFloat32Error(parameters, x), 1e-6)
        << "weights " << parameters.scales[0] << ", " << parameters.scales[1] << ", ...";
  }
}

TEST(CovarianceMatrix, ArcsineInDoubleKeepsTheSameBoundInItsOwnRoundoff) {
  std::mt19937_64 random = TestRandom();
  const std::vector<double> points = AwkwardPoints(random, 6);
  const ConstMatrixView<double> x(points.data(), static_cast<int64_t>(points.size()) / 6, 6);
  // The float bound, 1e-6 = 16.8 u, with u = 2^-53.
  for (const CovarianceParameters& parameters : ArcsineFamilies()) {
    EXPECT_LE(WorstFloat64Error(parameters, x), 16.8 * std::ldexp(1.0, -53));
  }
}

TEST(CovarianceMatrix, SquaredExponentialIsAccurate) {
  std::mt19937_64 random = TestRandom();
  const std::vector<double> points = AwkwardPoints(random, 3);
  const ConstMatrixView<double> x(points.data(), static_cast<int64_t>(points.size()) / 3, 3);
  for (const double length : {0.1, 1.0, 10.0}) {
    const CovarianceParameters parameters =
        SquaredExponentialParameters({length, length, 2 * length}, 1.5);
    // Rounding x / l moves |x - x'| / l by at most 2 u sqrt(3) / l, and exp(-r^2 / 2) by 0.61 times
    // that; the sum, the polynomial and the scaling add less than 10 u.
    const double units = 0.61 * 2 * std::sqrt(3.0) / length + 10;
    EXPECT_LE(WorstFloat32Error(parameters, x), units * std::ldexp(1.0, -24));
    EXPECT_LE(WorstFloat64Error(parameters, x), units * std::ldexp(1.0, -53));
  }
}

void ExpectTriangleAndFullAgree(int64_t n) {
  std::mt19937_64 random = TestRandom();
  const CovarianceParameters parameters = ArcsineParameters({1, 2, 3}, 1.2);
  const std::vector<double> points = RandomPoints(random, n, 2);
  const ConstMatrixView<double> x(points.data(), n, 2);
  GuardedMatrix<double> full(n, n, 5);
  GuardedMatrix<double> lower(n, n, 2);
  ASSERT_TRUE(
      CovarianceMatrix(*TestContext(), parameters, x, 0.25, Triangle::kFull, full.view()).ok());
  ASSERT_TRUE(
      CovarianceMatrix(*TestContext(), parameters, x, 0.25, Triangle::kLower, lower.view()).ok());
  EXPECT_TRUE(full.guards_intact());
  EXPECT_TRUE(lower.guards_intact());
  const double u = std::numeric_limits<double>::epsilon() / 2;
  for (int64_t i = 0; i < n; ++i) {
    for (int64_t j = 0; j < n; ++j) {
      const double noise = i == j ? 0.25 : 0.0;
      ASSERT_NEAR(full(i, j),
                  static_cast<double>(ExactCovariance(parameters, x.row(i), x.row(j))) + noise,
                  20 * u * 1.44);
      ASSERT_EQ(full(i, j), full(j, i));
      ASSERT_EQ(lower(i, j), j <= i ? full(i, j) : GuardedMatrix<double>::kCanary)
          << i << ", " << j;
    }
  }
}

TEST(CovarianceMatrix, TrianglesAtSizesAroundEveryBlock) {
  for (const int64_t n : {0, 1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 31, 33, 100}) {
    ExpectTriangleAndFullAgree(n);
  }
}

TEST(CovarianceMatrix, DevicesWithoutFloat64LeaveDoublesToTheHost) {
  std::mt19937_64 random = TestRandom();
  const auto context = Value(OpenContext({.float64 = false}));
  const CovarianceParameters parameters = ArcsineParameters({1, 20, 3});
  const std::vector<double> points = RandomPoints(random, 30, 2);
  const ConstMatrixView<double> x(points.data(), 30, 2);
  GuardedMatrix<double> doubles(30, 30);
  ASSERT_TRUE(CovarianceMatrix(*context, parameters, x, 0.0, Triangle::kFull, doubles.view()).ok());
  for (int i = 0; i < 30; ++i) {
    for (int j = 0; j < 30; ++j) {
      const double exact = static_cast<double>(ExactCovariance(parameters, x.row(i), x.row(j)));
      ASSERT_NEAR(doubles(i, j), exact, 16.8 * std::ldexp(1.0, -53));
    }
  }
}

TEST(CovarianceMatrix, RectanglesOfEverySizeStayInTheirBounds) {
  std::mt19937_64 random = TestRandom();
  const CovarianceParameters parameters = ArcsineParameters({1, 2, 3});
  const std::vector<double> points = RandomPoints(random, 40, 2);
  for (const int64_t rows : {0, 1, 4, 5}) {
    for (const int64_t cols : {0, 1, 7, 8, 9, 15, 16, 17, 33}) {
      GuardedMatrix<double> out(rows, cols, 1);
      ASSERT_TRUE(CrossCovariance(*TestContext(), parameters, {points.data(), rows, 2},
                                  {points.data() + 10, cols, 2}, out.view())
                      .ok());
      EXPECT_TRUE(out.guards_intact()) << rows << " x " << cols;
      for (int64_t i = 0; i < rows; ++i) {
        for (int64_t j = 0; j < cols; ++j) {
          ASSERT_NEAR(
              out(i, j),
              static_cast<double>(ExactCovariance(parameters, &points[2 * i], &points[10 + 2 * j])),
              1e-6);
        }
      }
    }
  }
}

TEST(CovarianceMatrix, BadArgumentsAreNamedAndNothingIsWritten) {
  std::mt19937_64 random = TestRandom();
  std::vector<double> points = RandomPoints(random, 10, 2);
  const CovarianceParameters good = ArcsineParameters({1, 2, 3});
  GuardedMatrix<double> out(10, 10);
  const auto message_of = [&](const CovarianceParameters& parameters, ConstMatrixView<double> x,
                              double noise) {
    const absl::Status status =
        CovarianceMatrix(*TestContext(), parameters, x, noise, Triangle::kFull, out.view());
    EXPECT_THAT(status, IsInvalid());
    EXPECT_TRUE(out.untouched());
    return std::string(status.message());
  };
  const ConstMatrixView<double> x(points.data(), 10, 2);
  EXPECT_THAT(message_of(ArcsineParameters({1, -2, 3}), x, 0.1),
              testing::HasSubstr("scales[1] = -2"));
  EXPECT_THAT(message_of(ArcsineParameters({1, NAN, 3}), x, 0.1),
              testing::HasSubstr("scales[1] = nan"));
  EXPECT_THAT(message_of(ArcsineParameters({1}), x, 0.1), testing::HasSubstr("dimension 0"));
  EXPECT_THAT(message_of(ArcsineParameters(std::vector<double>(258, 1.0)), x, 0.1),
              testing::HasSubstr("dimension 257"));
  EXPECT_THAT(message_of(good, {points.data(), 9, 2}, 0.1), testing::HasSubstr("out is 10 x 10"));
  EXPECT_THAT(message_of(good, x, NAN), testing::HasSubstr("noise_variance is nan"));
  EXPECT_THAT(message_of(good, x, -1.0), testing::HasSubstr("noise_variance is -1"));
  points[13] = NAN;
  EXPECT_THAT(message_of(good, x, 0.1), testing::HasSubstr("x(6, 1) = nan"));
}

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

std::vector<CovarianceParameters> Covariances() {
  return {ArcsineParameters({1.0, 1.5, 0.3, 4.0}, 1.3),
          ArcsineParameters({0.05, 30.0, 5.0, 0.2}, 0.7),
          SquaredExponentialParameters({0.5, 1.0, 3.0}, 1.2)};
}

// The reference's derivatives: EveryFunction.DerivativesAreFiniteDifferences.
TEST(CovarianceGradient, AgreesWithTheReferenceAtSizesAroundEveryBlock) {
  std::mt19937_64 random = TestRandom();
  for (const CovarianceParameters& parameters : Covariances()) {
    for (const int64_t n : {0, 1, 3, 4, 5, 7, 8, 9, 16, 17, 63, 130}) {
      const std::vector<double> points = RandomPoints(random, n, 3);
      const ConstMatrixView<double> x(points.data(), n, 3);
      GuardedMatrix<double> w = LowerWeights(random, n);
      const auto gradient = Value(CovarianceGradient(*TestContext(), parameters, x, w.view()));
      const std::vector<double> expected =
          reference::CovarianceGradient(parameters, x, x, w.view(), true);
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
          reference::CovarianceGradient(parameters, x, z, w.view(), false);
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
  const auto context = Value(OpenContext({.float64 = false}));
  const std::vector<double> points = RandomPoints(random, 30, 3);
  GuardedMatrix<double> w = LowerWeights(random, 30);
  for (const CovarianceParameters& parameters : Covariances()) {
    const ConstMatrixView<double> x(points.data(), 30, 3);
    const auto gradient = Value(CovarianceGradient(*context, parameters, x, w.view()));
    EXPECT_EQ(gradient, reference::CovarianceGradient(parameters, x, x, w.view(), true));
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
  EXPECT_THAT(CovarianceGradient(*TestContext(), ArcsineParameters({1, 1, 0, 1}), x, w.view()),
              IsInvalid("scales[2] = 0"));
  w.view()(7, 2) = INFINITY;
  EXPECT_THAT(CovarianceGradient(*TestContext(), parameters, x, w.view()), IsInvalid("row 7 of w"));
}

}  // namespace
}  // namespace egosieve::kernels
