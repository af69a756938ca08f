#include "vision/evidence/road_plane.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace egosieve::vision {
namespace {

constexpr double kHeight = 1.4, kTravel = 0.9;  // of the camera, metres; a pair
constexpr int kStep = 5;                        // pixels between the points
const cv::Size kImage(640, 360);

enum class What { kRoad, kStanding, kAhead, kOncoming, kHouse, kSky };

struct Seen {
  What what = What::kSky;
  double depth = 1e6;         // metres, at the second frame
  double approach = kTravel;  // metres that it came nearer between the frames
};

// A flat road; at 15 m, from left to right: a parked car, a car ahead at the camera's speed, an
// oncoming one of the same; beyond 60 m houses, above them sky.
Seen Look(const Eigen::Vector3d& ray) {
  const double road = ray(1) > 1e-6 ? kHeight / ray(1) : 1e9;
  constexpr double kCar = 15.0, kTop = -0.02;  // of A_y: 0.3 m above the camera
  const double foot = kHeight / kCar;
  if (ray(1) < foot && ray(1) > kTop && road > kCar) {
    if (ray(0) > -0.45 && ray(0) < -0.3) return {What::kStanding, kCar, kTravel};
    if (ray(0) > -0.1 && ray(0) < 0.05) return {What::kAhead, kCar, 0.0};
    if (ray(0) > 0.2 && ray(0) < 0.35) return {What::kOncoming, kCar, 2.0 * kTravel};
  }
  if (road < 60.0) return {What::kRoad, road, kTravel};
  if (ray(1) > -0.3) return {What::kHouse, 60.0, kTravel};
  return {};
}

struct View {
  Pinhole camera = Pinhole::Of(kImage, 420);
  RelativePose pose;
  std::vector<PointPair> pairs;
  std::vector<cv::Point2f> places;
  std::vector<What> what;
};

// The camera moves straight ahead; places are off by `noise` pixels.
View MakeView(double noise) {
  View view;
  view.pose.outcome = PoseOutcome::kFound;
  view.pose.translation = -Eigen::Vector3d::UnitZ();
  view.pose.noise_pixels = std::max(noise, 0.05);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, noise > 0 ? noise : 1e-9);
  for (int y = 2; y < kImage.height; y += kStep) {
    for (int x = 2; x < kImage.width; x += kStep) {
      const Eigen::Vector3d ray = view.camera.Ray(x, y);
      const Seen seen = Look(ray);
      const Eigen::Vector3d before = seen.depth * ray + seen.approach * Eigen::Vector3d::UnitZ();
      const Eigen::Vector2d place = view.camera.Project(before);
      view.pairs.push_back({place(0) + normal(random), place(1) + normal(random),
                            static_cast<double>(x), static_cast<double>(y)});
      view.places.emplace_back(x, y);
      view.what.push_back(seen.what);
    }
  }
  return view;
}

double ShareAbove(const View& view, const std::vector<double>& ratios, What what, double level) {
  double above = 0.0, count = 0.0;
  for (size_t i = 0; i < ratios.size(); ++i) {
    if (view.what[i] != what) continue;
    ++count;
    above += ratios[i] > level ? 1.0 : 0.0;
  }
  return above / count;
}

TEST(RoadPlane, IsFoundAndTellsCarsAheadAndOncomingFromParkedOnes) {
  for (const double noise : {0.0, 0.1}) {
    const View view = MakeView(noise);
    const auto depths = InverseDepths(view.camera, view.pose, view.pairs);
    const RoadPlane road = FitRoad(depths, {}, 1);
    ASSERT_TRUE(road.found);
    // r is in units of 1 / kTravel, so m_y = kTravel / kHeight; the horizon is level.
    EXPECT_NEAR(road.m(1), kTravel / kHeight, 0.02 * kTravel / kHeight);
    EXPECT_NEAR(road.m(2) / road.m(1), 0.0, 0.002);
    const auto ratios = RoadLogRatios(road, depths, view.places, kImage);
    EXPECT_GT(ShareAbove(view, ratios, What::kAhead, 2.0), 0.8) << noise;
    EXPECT_GT(ShareAbove(view, ratios, What::kOncoming, 2.0), 0.8) << noise;
    EXPECT_EQ(ShareAbove(view, ratios, What::kStanding, 1.0), 0.0) << noise;
    EXPECT_LT(ShareAbove(view, ratios, What::kRoad, 1.0), 0.002) << noise;
    EXPECT_LT(ShareAbove(view, ratios, What::kHouse, 1.0), 0.01) << noise;
    EXPECT_EQ(ShareAbove(view, ratios, What::kSky, 1.0), 0.0) << noise;
  }
}

TEST(RoadPlane, NoRoadNoEvidence) {
  // A wall across the whole view.
  View view = MakeView(0.1);
  for (PointPair& pair : view.pairs) {
    const Eigen::Vector3d ray = view.camera.Ray(pair.x2, pair.y2);
    const Eigen::Vector2d place =
        view.camera.Project(12.0 * ray + kTravel * Eigen::Vector3d::UnitZ());
    pair.x1 = place(0);
    pair.y1 = place(1);
  }
  const auto depths = InverseDepths(view.camera, view.pose, view.pairs);
  const RoadPlane road = FitRoad(depths, {}, 1);
  EXPECT_FALSE(road.found);
  for (const double ratio : RoadLogRatios(road, depths, view.places, kImage)) EXPECT_EQ(ratio, 0.0);
  EXPECT_FALSE(FitRoad({}, {}, 1).found);
}

TEST(RoadPlane, FollowsTheLastSlopeOnly) {
  const View view = MakeView(0.1);
  const auto depths = InverseDepths(view.camera, view.pose, view.pairs);
  EXPECT_TRUE(FitRoad(depths, {true, 0.0, 0.01}, 1).found);
  // Ten degrees of roll from one frame to the next are another plane.
  EXPECT_FALSE(FitRoad(depths, {true, 0.14, 0.0}, 1).found);
}

TEST(RoadPlane, PlacesThatAreNoNumbersSayNothing) {
  View view = MakeView(0.1);
  for (size_t i = 0; i < view.pairs.size(); i += 7) view.pairs[i].x1 = std::nan("");
  const auto depths = InverseDepths(view.camera, view.pose, view.pairs);
  const RoadPlane road = FitRoad(depths, {}, 1);
  ASSERT_TRUE(road.found);
  const auto ratios = RoadLogRatios(road, depths, view.places, kImage);
  for (size_t i = 0; i < ratios.size(); ++i) {
    EXPECT_TRUE(std::isfinite(ratios[i])) << i;
    if (i % 7 == 0) {
      EXPECT_EQ(ratios[i], 0.0) << i;
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
