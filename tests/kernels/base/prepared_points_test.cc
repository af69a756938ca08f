#include "kernels/base/prepared_points.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/covariance/arcsine.h"
#include "tests/kernels/test_data.h"

namespace egosieve::kernels {
namespace {

TEST(PreparePoint, AVectorAndItsRestHaveUnitLength) {
  std::mt19937_64 random = TestRandom();
  for (const double weight : {0.05, 1.0, 30.0, 1000.0}) {
    const CovarianceParameters parameters =
        ArcsineParameters({weight, 2 * weight, 0.5 * weight, weight});
    const std::vector<double> x = RandomPoints(random, 1, 3);
    double prepared[5];
    PreparePoint(parameters, x.data(), prepared, 1);
    // (1): 4 |a^ / 2|^2 + 4 (e / 4) = 1, a handful of roundings.
    double sum = prepared[4];
    for (int c = 0; c < 4; ++c) sum += prepared[c] * prepared[c];
    EXPECT_NEAR(4 * sum, 1.0, 16 * std::ldexp(1.0, -53));
    EXPECT_NEAR(prepared[1] / prepared[0], 2 * x[0], 1e-14);
  }
}

TEST(PreparePoint, DifferencesAndDotProductGiveTheSameH) {
  std::mt19937_64 random = TestRandom();
  const CovarianceParameters parameters = ArcsineParameters({1.0, 2.0, 3.0});
  for (int repeat = 0; repeat < 100; ++repeat) {
    const std::vector<double> x = RandomPoints(random, 2, 2);
    double a[4], b[4];
    PreparePoint(parameters, &x[0], a, 1);
    PreparePoint(parameters, &x[2], b, 1);
    double z = 0.0;
    for (int c = 0; c < 3; ++c) z += 4 * a[c] * b[c];
    const double sign = z < 0 ? -1.0 : 1.0;
    double h = a[3] + b[3];
    for (int c = 0; c < 3; ++c) h += (a[c] - sign * b[c]) * (a[c] - sign * b[c]);
    EXPECT_NEAR(h, (1 - std::abs(z)) / 2, 1e-15);  // (2)
    EXPECT_NEAR(sign * (M_PI / 2 - 2 * std::asin(std::sqrt(h))), std::asin(z),
                1e-14 / std::sqrt(h));  // (3)
  }
}

TEST(PreparePoint, WritesWithTheGivenStepInEveryType) {
  const CovarianceParameters parameters = SquaredExponentialParameters({0.5, 2.0});
  const float x[] = {1.0f, 3.0f};
  std::vector<float> out(9, -1.0f);
  PreparePoint(parameters, x, out.data(), 4);
  EXPECT_EQ(out, (std::vector<float>{2.0f, -1, -1, -1, 1.5f, -1, -1, -1, -1}));
}

TEST(PreparePoint, HugeWeightsKeepEPositiveInFloat) {
  const double x = 1.0;
  float out[3];
  PreparePoint(ArcsineParameters({1e30, 1e30}), &x, out, 1);
  EXPECT_GT(out[2], 0.0f);
  EXPECT_NEAR(out[0], std::sqrt(0.125), 1e-7);
}

TEST(CentreOf, IsTheMiddleOfARangeThatLeavesZeroOut) {
  const double x[] = {10.0, -1.0, -7.0, 14.0, 3.0, -5.0, 11.0, 0.0, -6.0};
  EXPECT_EQ(CentreOf({x, 3, 3}), (std::vector<double>{12.0, 0.0, -6.0}));
  EXPECT_EQ(CentreOf({x, 0, 3}), (std::vector<double>{0.0, 0.0, 0.0}));
}

TEST(DifferenceThreshold, IsWhereTheBoundOfTheDotProductMeetsOneMillionth) {
  const double u = std::ldexp(1.0, -24);
  double last = 0.0;
  for (int components = 2; components <= 33; ++components) {
    const double h = DifferenceThreshold(components);
    EXPECT_GE(h, last);
    last = h;
    if (h == 1.0) continue;
    const double roundings = (components + 1) / 2 + 3;
    EXPECT_NEAR(roundings * u / (2 * std::sqrt(h * (1 - h))) + 1.5e-7, 1e-6, 1e-12);
    EXPECT_LE(h, 0.5);
  }
  EXPECT_EQ(last, 1.0);  // 33 components need differences throughout
}

}  // namespace
}  // namespace egosieve::kernels
