#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "gtest/gtest.h"
#include "vision/synthetic/drive.h"
#include "vision/synthetic/primitive.h"

namespace egosieve::vision {
namespace {

using Eigen::Vector3d;

// Signed slack of the solid's defining inequality at a point of its frame: <= 0 inside.
double Outside(const Primitive& p, const Vector3d& q) {
  const Vector3d s = q.cwiseQuotient(p.half_size);
  switch (p.shape) {
    case Shape::kBox:
      return s.cwiseAbs().maxCoeff() - 1.0;
    case Shape::kEllipsoid:
      return s.norm() - 1.0;
    case Shape::kCylinder:
      return std::max(s.head<2>().norm(), std::abs(s.z())) - 1.0;
    case Shape::kProfile: {
      double worst = -1e9;
      for (const HalfSpace& h : p.profile->half_spaces)
        worst = std::max(worst, h.normal.dot(q) - h.offset);
      return worst;
    }
  }
  return 0.0;
}

class PrimitiveTest : public ::testing::TestWithParam<Shape> {
 protected:
  Primitive Make(std::mt19937_64& random) const {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    Primitive p;
    p.shape = GetParam();
    p.rotation = Eigen::AngleAxisd(3.0 * unit(random),
                                   Vector3d(unit(random), unit(random), 1.2).normalized())
                     .toRotationMatrix();
    p.origin = {unit(random), unit(random), unit(random)};
    p.half_size = {0.5 + 0.4 * unit(random), 0.5 + 0.4 * unit(random), 0.5 + 0.4 * unit(random)};
    if (p.shape == Shape::kCylinder) p.half_size.y() = p.half_size.x();
    if (p.shape == Shape::kProfile) {
      p.profile = MakeProfile({{-0.9, -0.4}, {0.8, -0.4}, {0.5, 0.3}, {-0.2, 0.5}}, 0.4, 0.2);
      p.half_size = p.profile->half_size;
    }
    return p;
  }
};

// Against marching along the ray in small steps: the first point inside the solid.
TEST_P(PrimitiveTest, FirstHitIsWhereTheRayEntersTheSolid) {
  std::mt19937_64 random(static_cast<uint64_t>(GetParam()) + 11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  constexpr double kStep = 2e-3;
  int hits = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Primitive p = Make(random);
    const Vector3d from =
        p.origin + 3.0 * Vector3d(unit(random), unit(random), unit(random)).normalized();
    const Vector3d aim = p.origin + 0.7 * Vector3d(unit(random), unit(random), unit(random));
    const Ray ray{from, (aim - from) * 0.4};
    double marched = -1.0;
    for (double t = 0.0; t < 6.0; t += kStep) {
      const Vector3d local = p.rotation.transpose() * (ray.origin + t * ray.direction - p.origin);
      if (Outside(p, local) <= 0.0) {
        marched = t;
        break;
      }
    }
    Hit hit;
    const bool met = Intersect(p, ray, 1e-9, &hit);
    if (marched < 0.0) {
      // A ray that only clips a corner may slip between two steps.
      if (met) {
        EXPECT_NEAR(Outside(p, hit.local), 0.0, 1e-9);
      }
      continue;
    }
    ++hits;
    ASSERT_TRUE(met);
    EXPECT_LE(hit.t, marched + 1e-12);
    EXPECT_GE(hit.t, marched - kStep - 1e-12);
    EXPECT_NEAR(Outside(p, hit.local), 0.0, 1e-9);
    const Vector3d world = p.rotation * hit.local + p.origin;
    EXPECT_NEAR((world - ray.origin - hit.t * ray.direction).norm(), 0.0, 1e-9);
    EXPECT_NEAR(hit.local_normal.norm(), 1.0, 1e-12);
    EXPECT_LT((p.rotation * hit.local_normal).dot(ray.direction), 1e-12);
    EXPECT_TRUE(p.Bounds().exteriorDistance(world) < 1e-9);
    Hit nearer;
    nearer.t = hit.t * 0.999;
    EXPECT_FALSE(Intersect(p, ray, 1e-9, &nearer));  // something nearer hides it
  }
  EXPECT_GT(hits, 100);
}

INSTANTIATE_TEST_SUITE_P(Shapes, PrimitiveTest,
                         ::testing::Values(Shape::kBox, Shape::kEllipsoid, Shape::kCylinder,
                                           Shape::kProfile));

TEST(PrimitiveFacesTest, RayAlongAnAxisHitsTheFaceThatLooksAtIt) {
  Primitive box;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Hit hit;
      ASSERT_TRUE(Intersect(box, {sign * 5.0 * Vector3d::Unit(axis), -sign * Vector3d::Unit(axis)},
                            0.0, &hit));
      EXPECT_EQ(hit.t, 4.0);
      EXPECT_EQ(hit.face, 2 * axis + (sign > 0.0 ? 1 : 0));
      EXPECT_EQ(hit.local_normal, sign * Vector3d::Unit(axis));
    }
  }
  Hit hit;  // parallel to two slabs, outside of them
  EXPECT_FALSE(Intersect(box, {{5.0, 1.5, 0.0}, {-1.0, 0.0, 0.0}}, 0.0, &hit));
}

TEST(PathTest, QuarterTurnEndsBesideItsCentre) {
  Path path({1.0, 2.0}, 0.0);
  path.Straight(10.0).Turn(5.0, M_PI / 2).Straight(3.0);
  const double arc = 5.0 * M_PI / 2;
  const PathPoint end = path.At(10.0 + arc + 3.0);
  EXPECT_NEAR(end.position.x(), 1.0 + 10.0 + 5.0, 1e-12);
  EXPECT_NEAR(end.position.y(), 2.0 + 5.0 + 3.0, 1e-12);
  EXPECT_NEAR(end.heading_radians, M_PI / 2, 1e-12);
}

TEST(PathTest, IsAUnitSpeedCurve) {
  Path path({0.0, 0.0}, 0.3);
  path.Straight(4.0).Turn(6.0, -1.1).Turn(3.0, 2.0).Straight(2.0);
  constexpr double kStep = 1e-5;
  for (double s = -2.0; s < 25.0; s += 0.37) {
    const Eigen::Vector2d tangent =
        (path.At(s + kStep).position - path.At(s - kStep).position) / (2 * kStep);
    const double heading = path.At(s).heading_radians;
    // Central differences: error of order step^2 curvature^2, and step curvature at joints.
    EXPECT_NEAR(tangent.x(), std::cos(heading), 1e-5) << s;
    EXPECT_NEAR(tangent.y(), std::sin(heading), 1e-5) << s;
  }
}

TEST(PathTest, ShiftMovesToTheLeft) {
  Path path({0.0, 0.0}, M_PI);  // westwards: left is south
  path.Straight(100.0).Shift(10.0, 30.0, 3.0);
  EXPECT_NEAR(path.At(5.0).position.y(), 0.0, 1e-12);
  EXPECT_NEAR(path.At(20.0).position.y(), -1.5, 1e-12);
  EXPECT_NEAR(path.At(40.0).position.y(), -3.0, 1e-12);
  EXPECT_GT(path.At(20.0).heading_radians, M_PI);
}

TEST(DriveTest, TravelledIsTheIntegralOfSpeed) {
  const Drive drive(Path({0.0, 0.0}, 0.0), 7.0,
                    {{-1.0, 4.0}, {2.0, 10.0}, {3.0, 0.0}, {5.0, 0.0}, {6.0, 2.0}});
  EXPECT_EQ(drive.Travelled(0.0), 0.0);
  EXPECT_NEAR(drive.Travelled(2.0), 0.5 * 2.0 * (6.0 + 10.0), 1e-12);
  EXPECT_NEAR(drive.Travelled(4.0), 16.0 + 5.0, 1e-12);
  EXPECT_NEAR(drive.Travelled(8.0), 16.0 + 5.0 + 1.0 + 4.0, 1e-12);
  EXPECT_NEAR(drive.Travelled(-3.0), -(0.5 * (4.0 + 6.0) + 2.0 * 4.0), 1e-12);
  EXPECT_EQ(drive.Speed(4.0), 0.0);
  EXPECT_EQ(drive.At(4.2).pose.position, drive.At(4.8).pose.position);
  EXPECT_NEAR(drive.At(2.0).pose.position.x(), 7.0 + 16.0, 1e-12);
  EXPECT_NEAR(drive.At(1.0).velocity.x(), 8.0, 1e-6);
}

TEST(DriveTest, WithoutKeysItStands) {
  const Drive drive(Path({3.0, 4.0}, 1.0), 0.0, {});
  EXPECT_EQ(drive.At(9.0).pose.position, Eigen::Vector2d(3.0, 4.0));
  EXPECT_EQ(drive.At(9.0).velocity.norm(), 0.0);
}

}  // namespace
}  // namespace egosieve::vision
