#include "vision/evidence/residual_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace egosieve::vision {
namespace {

// Box and Muller: two normal numbers.
std::pair<double, double> Normals(std::mt19937_64& random) {
  const double u = (static_cast<double>(random() >> 11) + 1) * 0x1p-53;
  const double v = static_cast<double>(random() >> 11) * 0x1p-53;
  const double r = std::sqrt(-2 * std::log(u));
  return {r * std::cos(2 * M_PI * v), r * std::sin(2 * M_PI * v)};
}

TEST(ResidualScale, FindsTheDeviationBesideAQuarterOfMovers) {
  for (const int dimensions : {1, 2}) {
    std::mt19937_64 random(dimensions);
    std::vector<double> residuals;
    for (int i = 0; i < 9000; ++i) {
      const auto [a, b] = Normals(random);
      residuals.push_back(0.7 * (dimensions == 1 ? a : std::hypot(a, b)));
    }
    // 9000 numbers: 0.8 % in one dimension.
    EXPECT_NEAR(ResidualScale(residuals, dimensions, 0.1), 0.7, 0.03);
    for (int i = 0; i < 3000; ++i) residuals.push_back(static_cast<double>(random() % 5000) / 100);
    // 3.5 % of the movers lie below 2.5 sigma: 1 % of the points, at up to 2.5 sigma.
    EXPECT_NEAR(ResidualScale(residuals, dimensions, 0.1), 0.7, 0.06);
  }
}

TEST(ResidualScale, FloorAndNumbersThatAreNone) {
  EXPECT_EQ(ResidualScale({}, 1, 0.25), 0.25);
  EXPECT_EQ(ResidualScale({0, 0, 0, 0}, 1, 0.25), 0.25);
  EXPECT_EQ(ResidualScale({std::nan(""), std::numeric_limits<double>::infinity()}, 2, 0.25), 0.25);
}

}  // namespace
}  // namespace egosieve::vision
