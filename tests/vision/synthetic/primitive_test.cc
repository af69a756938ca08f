#include "vision/synthetic/primitive.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

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

}  // namespace
}  // namespace egosieve::vision
