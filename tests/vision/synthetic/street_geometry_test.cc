// The geometry of synthetic frames: what poses and depth say is what the pictures show.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <random>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/testing/status.h"
#include "vision/statistics/order_statistics.h"
#include "vision/synthetic/camera.h"
#include "vision/synthetic/drive.h"
#include "vision/synthetic/primitive.h"
#include "vision/synthetic/ray_caster.h"
#include "vision/synthetic/street.h"

namespace egosieve::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Scenario Make(const char* name) {
  return Value(MakeScenario(name, 3, {.noise = false, .motion_blur = false}));
}

Vector3d World(const Intrinsics& k, const Pose& pose, double x, double y, double depth) {
  const Vector3d ray((x - k.centre_x) / k.focal_pixels, (y - k.centre_y) / k.focal_pixels, 1.0);
  return pose.rotation * (depth * ray) + pose.centre;
}

Vector3d Camera(const Pose& pose, const Vector3d& world) {
  return pose.rotation.transpose() * (world - pose.centre);
}

Vector2d Pixel(const Intrinsics& k, const Vector3d& camera) {
  return {k.focal_pixels * camera.x() / camera.z() + k.centre_x,
          k.focal_pixels * camera.y() / camera.z() + k.centre_y};
}

// Zero if the centres coincide.
Eigen::Matrix3d FundamentalMatrix(const Intrinsics& intrinsics, const Pose& first,
                                  const Pose& second) {
  const Eigen::Vector3d t = second.rotation.transpose() * (first.centre - second.centre);
  Eigen::Matrix3d cross;
  cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
  Eigen::Matrix3d k;
  k << intrinsics.focal_pixels, 0.0, intrinsics.centre_x, 0.0, intrinsics.focal_pixels,
      intrinsics.centre_y, 0.0, 0.0, 1.0;
  const Eigen::Matrix3d k_inverse = k.inverse();
  return k_inverse.transpose() * cross * second.rotation.transpose() * first.rotation * k_inverse;
}

// Of p2 from the epipolar line of p1, pixels.
double EpipolarDistance(const Eigen::Matrix3d& f, const Vector2d& p1, const Vector2d& p2) {
  const Vector3d line = f * p1.homogeneous();
  return std::abs(line.dot(p2.homogeneous())) / line.head<2>().norm();
}

double Grey(const cv::Mat& image, double x, double y) {
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const auto at = [&](int u, int v) {
    const auto& p = image.at<cv::Vec3b>(v, u);
    return (p[0] + p[1] + p[2]) / 3.0;
  };
  const double s = x - i, t = y - j;
  return (at(i, j) * (1 - s) + at(i + 1, j) * s) * (1 - t) +
         (at(i, j + 1) * (1 - s) + at(i + 1, j + 1) * s) * t;
}

class StreetGeometryTest : public ::testing::TestWithParam<const char*> {};

// Each static point of frame t, carried to frame t + 1 by depth and poses alone, is met there by a
// ray at the same depth, unless something else hides it, and the pictures agree about its grey.
TEST_P(StreetGeometryTest, StaticPointsReappearWhereThePosesPutThem) {
  const Scenario scenario = Make(GetParam());
  const Intrinsics& k = scenario.intrinsics();
  const SceneIndex index(scenario.scene());
  for (const int t : {20, 90}) {
    const SyntheticFrame first = *scenario.Render(t), second = *scenario.Render(t + 1);
    const RayCaster caster(scenario.scene(), index, second.seconds, 640, 360);
    const Eigen::Matrix3d f = FundamentalMatrix(k, first.pose, second.pose);
    int checked = 0, met = 0;
    std::vector<double> at_place, beside;
    for (int y = 1; y < 359; y += 3) {
      for (int x = 1; x < 639; x += 3) {
        const double depth = first.depth.at<double>(y, x);
        if (std::isinf(depth) || first.mask.at<uint8_t>(y, x) != 0) continue;
        const Vector3d there = Camera(second.pose, World(k, first.pose, x, y, depth));
        const Vector2d pixel = Pixel(k, there);
        if (!(there.z() > 0.1 && pixel.x() > 1 && pixel.y() > 1 && pixel.x() < 634 &&
              pixel.y() < 354))
          continue;
        ++checked;
        const double seen = caster.Cast(pixel.x(), pixel.y()).depth();
        // Depth is float64 throughout: 1e-6 leaves three digits for rays that graze the road.
        if (std::abs(seen / there.z() - 1.0) > 1e-6) continue;
        ++met;
        EXPECT_LT(EpipolarDistance(f, Vector2d(x, y), pixel), 0.01);
        const double grey = Grey(first.image, x, y);
        at_place.push_back(std::abs(Grey(second.image, pixel.x(), pixel.y()) - grey));
        beside.push_back(std::abs(Grey(second.image, pixel.x() + 4, pixel.y() + 3) - grey));
      }
    }
    ASSERT_GT(checked, 10000);
    EXPECT_GT(met, 0.93 * checked);  // the rest is newly hidden
    // Between frames only texture filtering and clouds differ: a few grey levels.
    EXPECT_LT(Median(at_place), 4.0);
    EXPECT_LT(Median(at_place), 0.5 * Median(beside));
  }
}

// Points on a mover, carried by its truth velocity as well, are met too.
TEST_P(StreetGeometryTest, MovingPointsFollowTheirVelocity) {
  const Scenario scenario = Make(GetParam());
  const Intrinsics& k = scenario.intrinsics();
  const SceneIndex index(scenario.scene());
  const double step = 1e-3;  // seconds: turns hardly change the velocity
  int checked = 0, met = 0;
  for (int t = 10; t < 150; t += 20) {
    const SyntheticFrame frame = *scenario.Render(t);
    const RayCaster later(scenario.scene(), index, frame.seconds + step, 640, 360);
    for (int y = 0; y < 360; ++y) {
      for (int x = 0; x < 640; ++x) {
        const int id = frame.ids.at<uint16_t>(y, x);
        if (id == 0 || frame.mask.at<uint8_t>(y, x) == 0) continue;
        const auto object = std::find_if(frame.objects.begin(), frame.objects.end(),
                                         [&](const ObjectState& o) { return o.id == id; });
        if (object->object_class != ObjectClass::kCar) continue;  // rigid but for its round wheels
        const Vector3d world =
            World(k, frame.pose, x, y, frame.depth.at<double>(y, x)) + step * object->velocity;
        const Vector3d there = Camera(later.pose(), world);
        const Vector2d pixel = Pixel(k, there);
        if (!(pixel.x() > 0 && pixel.y() > 0 && pixel.x() < 639 && pixel.y() < 359)) continue;
        ++checked;
        const Sample seen = later.Cast(pixel.x(), pixel.y());
        met += seen.object == id - 1 && std::abs(seen.depth() / there.z() - 1.0) < 1e-5;
      }
    }
  }
  ASSERT_GT(checked, 500);
  EXPECT_GT(met, 0.97 * checked);
}

TEST(Intrinsics, UndistortIsTheInverseOfProject) {
  for (const double radial : {-0.15, 0.0, 0.3}) {
    Intrinsics k{400.0, 319.5, 179.5, radial};
    ASSERT_TRUE(k.DistortsUpTo(370.0));
    for (const Vector2d& pixel : {Vector2d(0, 0), {639, 359}, {319.5, 179.5}, {100, 300}}) {
      const Vector2d u = k.Undistort(pixel.x(), pixel.y());
      EXPECT_LT((k.Project(3.0 * u.homogeneous()) - pixel).norm(), 1e-9) << radial;
    }
  }
  // r (1 - 0.3 r^2) is largest at r = (0.9)^-1/2, where it is 0.70.
  const Intrinsics folded{400.0, 319.5, 179.5, -0.3};
  EXPECT_TRUE(folded.DistortsUpTo(281.0));
  EXPECT_FALSE(folded.DistortsUpTo(282.0));
}

// A lens bends the picture and not the world: a pixel's ray meets what the pinhole camera's ray in
// the same direction meets.
TEST(Intrinsics, DistortedRaysMeetWhatPinholeRaysMeet) {
  ScenarioOptions options;
  const Scenario pinhole = *MakeScenario("street", 3, options);
  const SceneIndex index(pinhole.scene());
  const RayCaster straight(pinhole.scene(), index, 4.0, 640, 360);
  for (const double radial : {-0.15, 0.15}) {
    options.radial = radial;
    const Scenario bent = *MakeScenario("street", 3, options);
    const RayCaster caster(bent.scene(), index, 4.0, 640, 360);
    int checked = 0;
    for (int y = 0; y < 360; y += 5) {
      for (int x = 0; x < 640; x += 5) {
        const Vector2d pixel =
            pinhole.intrinsics().Project(bent.intrinsics().Undistort(x, y).homogeneous());
        if (!(pixel.x() > 0 && pixel.y() > 0 && pixel.x() < 639 && pixel.y() < 359)) continue;
        const Sample a = caster.Cast(x, y), b = straight.Cast(pixel.x(), pixel.y());
        ++checked;
        EXPECT_EQ(a.object, b.object);
        if (!std::isinf(a.depth())) {
          EXPECT_NEAR(a.depth() / b.depth(), 1.0, 1e-6);
        }
      }
    }
    EXPECT_GT(checked, 5000);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, StreetGeometryTest,
                         ::testing::Values("street", "turning", "handheld", "crossing"),
                         [](const auto& info) { return std::string(info.param); });

// What a feature detector finds in synthetic frames, noise and motion blur included.

class StreetFeaturesTest : public ::testing::TestWithParam<const char*> {};

struct Matches {
  std::vector<Vector2d> first, second;
};

Matches SiftMatches(const cv::Mat& first, const cv::Mat& second) {
  const auto sift = cv::SIFT::create();
  std::vector<cv::KeyPoint> a, b;
  cv::Mat da, db;
  sift->detectAndCompute(first, cv::noArray(), a, da);
  sift->detectAndCompute(second, cv::noArray(), b, db);
  std::vector<std::vector<cv::DMatch>> pairs;
  cv::BFMatcher(cv::NORM_L2).knnMatch(da, db, pairs, 2);
  Matches matches;
  for (const auto& pair : pairs) {
    if (pair.size() < 2 || !(pair[0].distance < 0.8f * pair[1].distance)) continue;
    const cv::Point2f p = a[pair[0].queryIdx].pt, q = b[pair[0].trainIdx].pt;
    matches.first.emplace_back(p.x, p.y);
    matches.second.emplace_back(q.x, q.y);
  }
  return matches;
}

// As natural as a street is to a feature detector; and the matches between static pixels lie on the
// epipolar lines of the poses.
TEST_P(StreetFeaturesTest, SiftFindsAndMatchesEnough) {
  const Scenario scenario = *MakeScenario(GetParam(), 3, {.frames_per_second = 15.0});
  double sum = 0.0;
  const std::vector<int> times = {20, 80, 140};
  for (const int t : times) {
    const SyntheticFrame first = *scenario.Render(t), second = *scenario.Render(t + 1);
    const Matches matches = SiftMatches(first.image, second.image);
    EXPECT_GE(matches.first.size(), 1200u) << "frame " << t;
    sum += static_cast<double>(matches.first.size());
    const Eigen::Matrix3d f = FundamentalMatrix(scenario.intrinsics(), first.pose, second.pose);
    std::vector<double> distances;
    for (size_t i = 0; i < matches.first.size(); ++i) {
      const cv::Point p(std::lround(matches.first[i].x()), std::lround(matches.first[i].y()));
      if (first.mask.at<uint8_t>(p) == 0) {
        distances.push_back(EpipolarDistance(f, matches.first[i], matches.second[i]));
      }
    }
    // SIFT localises to a few tenths of a pixel.
    EXPECT_LT(Median(distances), 0.4) << "frame " << t;
  }
  EXPECT_GE(sum / static_cast<double>(times.size()), 1500.0);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, StreetFeaturesTest, ::testing::Values("street", "handheld"),
                         [](const auto& info) { return std::string(info.param); });

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
    Primitive p{
        .shape = GetParam(),
        .rotation = Eigen::AngleAxisd(3.0 * unit(random),
                                      Vector3d(unit(random), unit(random), 1.2).normalized())
                        .toRotationMatrix(),
        .origin = {unit(random), unit(random), unit(random)},
        .half_size = {0.5 + 0.4 * unit(random), 0.5 + 0.4 * unit(random),
                      0.5 + 0.4 * unit(random)}};
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
    Hit nearer{.t = hit.t * 0.999};
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
