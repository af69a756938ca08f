#include "vision/statistics/robust_scale.h"

#include <cmath>
#include <random>
#include <vector>

#include "gtest/gtest.h"

namespace egosieve::vision {
namespace {

TEST(MadToDeviation, PutsHalfOfAGaussianWithinTheMedian) {
  // P(|x| < q) of N(0, 1). Its slope at q = 0.6745 is 2 phi(q) = 0.636, and five digits leave a
  // relative error of q of at most 5e-5 / 1.4826: 0.636 * 0.6745 * 3.4e-5 < 1.5e-5.
  EXPECT_NEAR(std::erf(1.0 / (kMadToDeviation * std::sqrt(2.0))), 0.5, 1.5e-5);
}

TEST(RobustScale, IsTheMedianTimesTheConstantAndNotBelowItsFloor) {
  EXPECT_EQ(RobustScale(std::vector<double>{3.0, 1.0, 2.0}, 0.2), 1.4826 * 2.0);
  EXPECT_EQ(RobustScale(std::vector<int>{5, 100, 5}, 0.2), 1.4826 * 5);
  EXPECT_EQ(RobustScale(std::vector<double>{0.0, 0.0, 9.0}, 0.2), 0.2);
  EXPECT_EQ(RobustScale(std::vector<double>{}, 0.2), 0.2);
}

TEST(RobustScale, IsTheStandardDeviationOfAGaussian) {
  std::mt19937_64 engine(1);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  std::vector<double> distances;
  for (int i = 0; i < 20001; ++i) {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    distances.push_back(0.7 * std::abs(radius * std::cos(2.0 * M_PI * uniform())));
  }
  // The sample median of 20001 has a relative standard error of 1.17 / sqrt(20001) = 0.8 %.
  EXPECT_NEAR(RobustScale(distances, 0.2), 0.7, 3 * 0.008 * 0.7);
}

}  // namespace
}  // namespace egosieve::vision
