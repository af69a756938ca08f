#include "vision/paper/seven_point.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace egosieve::vision {
namespace {

double Uniform(std::mt19937_64& engine) {
  return 2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0;
}

// Seven points of a random scene seen by two cameras, and F = [t]x R.
struct Scene {
  std::array<PointPair, 7> pairs;
  Eigen::Matrix3d f;
};

Scene RandomScene(std::mt19937_64& engine) {
  Scene scene;
  const Eigen::Vector3d t(Uniform(engine), Uniform(engine), Uniform(engine));
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 9; ++i)
    r(i / 3, i % 3) += 0.1 * Uniform(engine);  // any affine camera will do
  Eigen::Matrix3d cross;
  cross << 0, -t(2), t(1), t(2), 0, -t(0), -t(1), t(0), 0;
  scene.f = cross * r;
  scene.f /= scene.f.norm();
  for (PointPair& pair : scene.pairs) {
    const Eigen::Vector3d x(2 * Uniform(engine), 2 * Uniform(engine), 4 + Uniform(engine));
    const Eigen::Vector3d y = r * x + t;
    pair = {x(0) / x(2), x(1) / x(2), y(0) / y(2), y(1) / y(2)};
  }
  return scene;
}

double Difference(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return std::min((a - b).norm(), (a + b).norm());
}

TEST(SolveSevenPoint, ExactPairsGiveTheirMatrixAmongTheSolutions) {
  std::mt19937_64 engine(11);
  int exact = 0, three = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Scene scene = RandomScene(engine);
    const SevenPointSolutions solutions = SolveSevenPoint(scene.pairs);
    ASSERT_TRUE(solutions.count == 1 || solutions.count == 3) << solutions.count;
    three += solutions.count == 3;
    double best = 1.0;
    for (int i = 0; i < solutions.count; ++i) {
      const Eigen::Matrix3d& f = solutions.matrices[i];
      // Rank 2 and all seven constraints; a double root loses half the digits.
      EXPECT_LT(std::abs(f.determinant()), 1e-12);
      EXPECT_NEAR(f.norm(), 1.0, 1e-12);
      for (const PointPair& p : scene.pairs) {
        const double e = Eigen::Vector3d(p.x2, p.y2, 1).dot(f * Eigen::Vector3d(p.x1, p.y1, 1));
        EXPECT_LT(std::abs(e), 1e-9);
      }
      best = std::min(best, Difference(f, scene.f));
    }
    exact += best < 1e-6;
  }
  // The rest are samples so near to degenerate that 1e-16 of rounding grows to 1e-6.
  EXPECT_GE(exact, 495);
  EXPECT_GT(three, 50) << "scenes with three real roots were not met";
}

TEST(SolveSevenPoint, DegenerateSamplesAreRefused) {
  std::mt19937_64 engine(12);
  Scene scene = RandomScene(engine);
  std::array<PointPair, 7> repeated = scene.pairs;
  repeated[6] = repeated[2];
  EXPECT_EQ(SolveSevenPoint(repeated).count, 0);
  std::array<PointPair, 7> collinear, same;
  for (int i = 0; i < 7; ++i) collinear[i] = {0.1 * i, 0.2 * i, 0.1 * i + 0.3, 0.2 * i - 0.1};
  same.fill({0.1, 0.2, 0.3, 0.4});
  EXPECT_EQ(SolveSevenPoint(collinear).count, 0);
  EXPECT_EQ(SolveSevenPoint(same).count, 0);
  scene.pairs[3].x1 = NAN;
  EXPECT_EQ(SolveSevenPoint(scene.pairs).count, 0);
}

TEST(SolveSevenPoint, OrientationsAgreeForTheTrueMatrixAndItsNegative) {
  std::mt19937_64 engine(13);
  for (int trial = 0; trial < 50; ++trial) {
    const Scene scene = RandomScene(engine);
    EXPECT_TRUE(OrientationsAgree(scene.f, scene.pairs));
    EXPECT_TRUE(OrientationsAgree(-scene.f, scene.pairs));
  }
}

void ExpectRoots(const std::array<double, 4>& c, std::vector<double> expected) {
  std::array<double, 3> roots{};
  const int count = RealCubicRoots(c, roots);
  ASSERT_EQ(count, static_cast<int>(expected.size()));
  for (int i = 0; i < count; ++i)
    EXPECT_NEAR(roots[i], expected[i], 1e-7 * (1 + std::abs(expected[i])));
}

TEST(RealCubicRoots, OneThreeAndLowerDegrees) {
  ExpectRoots({-6, 11, -6, 1}, {1, 2, 3});
  ExpectRoots({-1, 0, 0, 1}, {1});
  ExpectRoots({0, 0, 0, 2}, {0, 0, 0});
  ExpectRoots({2, -3, 1, 0}, {1, 2});
  ExpectRoots({-4, 2, 0, 0}, {2});
  ExpectRoots({1, 0, 1, 0}, {});
  ExpectRoots({5, 0, 0, 0}, {});
  // Widely spread: (t - 1e-4)(t - 1)(t - 1e4).
  ExpectRoots({-1, 1e4 + 1 + 1e-4, -(1e4 + 1 + 1e-4), 1}, {1e-4, 1, 1e4});
}

TEST(RealCubicRoots, RandomRootsAreFound) {
  std::mt19937_64 engine(14);
  for (int trial = 0; trial < 1000; ++trial) {
    std::array<double, 3> r = {Uniform(engine), 3 * Uniform(engine), 10 * Uniform(engine)};
    std::sort(r.begin(), r.end());
    const double a = 1 + Uniform(engine) / 2;
    std::array<double, 3> found{};
    const int count =
        RealCubicRoots({-a * r[0] * r[1] * r[2], a * (r[0] * r[1] + r[0] * r[2] + r[1] * r[2]),
                        -a * (r[0] + r[1] + r[2]), a},
                       found);
    if (std::min(r[1] - r[0], r[2] - r[1]) < 1e-3)
      continue;  // nearly double: may be lost to rounding
    ASSERT_EQ(count, 3);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(found[i], r[i], 1e-8);
  }
}

}  // namespace
}  // namespace egosieve::vision
