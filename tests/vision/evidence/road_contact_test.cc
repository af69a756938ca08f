#include "vision/evidence/road_contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "tests/vision/evidence/road_view.h"

namespace egosieve::vision {
namespace {

double ShareAbove(const View& view, const std::vector<double>& ratios, What what, double level) {
  double above = 0.0, count = 0.0;
  for (size_t i = 0; i < ratios.size(); ++i) {
    if (view.what[i] != what) continue;
    ++count;
    above += ratios[i] > level ? 1.0 : 0.0;
  }
  return above / count;
}

struct RoadSeen {
  View view;
  std::vector<InverseDepth> depths;
  RoadPlane road;
};

RoadSeen LookAt(View view) {
  RoadSeen seen{std::move(view), {}, {}};
  seen.depths = InverseDepths(seen.view.camera, seen.view.pose, seen.view.pairs);
  seen.road = FitRoad(seen.depths, kLevel);
  return seen;
}

TEST(RoadContact, TellsCarsAheadAndOncomingFromParkedOnes) {
  for (const double noise : {0.0, 0.1}) {
    auto [view, depths, road] = LookAt(MakeView(noise));
    const auto ratios = RoadLogRatios(road, depths, view.places, kImage, nullptr);
    EXPECT_GT(ShareAbove(view, ratios, What::kAhead, 2.0), 0.8) << noise;
    EXPECT_GT(ShareAbove(view, ratios, What::kOncoming, 2.0), 0.8) << noise;
    EXPECT_EQ(ShareAbove(view, ratios, What::kStanding, 1.0), 0.0) << noise;
    EXPECT_LT(ShareAbove(view, ratios, What::kRoad, 1.0), 0.002) << noise;
    EXPECT_LT(ShareAbove(view, ratios, What::kHouse, 1.0), 0.01) << noise;
    EXPECT_EQ(ShareAbove(view, ratios, What::kSky, 1.0), 0.0) << noise;
  }
}

// Gives point i the motion of what is so far away, in metres, and comes nearer by so many.
void Approach(double depth, double approach, size_t i, View& view) {
  const Eigen::Vector3d ray = view.camera.Ray(view.places[i].x, view.places[i].y);
  const Eigen::Vector2d place =
      view.camera.Project(depth * ray + approach * Eigen::Vector3d::UnitZ());
  view.pairs[i].x1 = place(0);
  view.pairs[i].y1 = place(1);
}

// Beneath the car that comes, three places of road get its motion, as from smooth flow.
View WithBleedingFlow(std::vector<bool>& is_carried) {
  View view = MakeView(0.1);
  is_carried.assign(view.what.size(), false);
  const auto columns = static_cast<size_t>((kImage.width + kStep - 3) / kStep);
  for (size_t i = 0; i + 3 * columns < view.what.size(); ++i) {
    if (view.what[i] != What::kOncoming || view.what[i + columns] != What::kRoad) continue;
    for (size_t k = 1; k <= 3; ++k) {
      const size_t road = i + k * columns;
      Approach(15.0, 2.0 * kTravel, road, view);
      is_carried[road] = true;
    }
  }
  return view;
}

TEST(RoadContact, FlowThatIsCarriedOverTheRoadDoesNotHideTheContact) {
  std::vector<bool> is_carried;
  const View view = WithBleedingFlow(is_carried);
  auto [shown, depths, road] = LookAt(view);
  const auto blind = RoadLogRatios(road, depths, view.places, kImage, nullptr);
  for (size_t i = 0; i < depths.size(); ++i) {
    depths[i].against_road = view.what[i] == What::kRoad ? (is_carried[i] ? -5.0 : 0.0) : 20.0;
  }
  const auto seeing = RoadLogRatios(road, depths, view.places, kImage, nullptr);
  EXPECT_GT(ShareAbove(view, blind, What::kOncoming, 2.0), 0.9);
  EXPECT_EQ(ShareAbove(view, blind, What::kStanding, 1.0), 0.0);
  EXPECT_GT(ShareAbove(view, seeing, What::kOncoming, 2.0), 0.9);
  EXPECT_EQ(ShareAbove(view, seeing, What::kStanding, 1.0), 0.0);
  EXPECT_LT(ShareAbove(view, seeing, What::kRoad, 1.0), 0.002);
}

TEST(RoadContact, ColumnsWithoutAContactFollowTheRestOfTheSurface) {
  auto [view, depths, road] = LookAt(MakeView(0.1));
  // Nothing was measured below the right third of the car.
  for (size_t i = 0; i < depths.size(); ++i) {
    const double across = depths[i].ray(0);
    if (view.what[i] == What::kRoad && across > 0.3 && across < 0.35) depths[i].valid = false;
  }
  const auto ratios = RoadLogRatios(road, depths, view.places, kImage, nullptr);
  EXPECT_GT(ShareAbove(view, ratios, What::kOncoming, 2.0), 0.9);
}

TEST(RoadContact, OneColumnWithAWrongContactDoesNotMarkTheSurface) {
  auto [view, depths, road] = LookAt(MakeView(0.1));
  constexpr float kColumn = 162.0f;
  // There, the lower part of the parked car passes for road.
  for (size_t i = 0; i < depths.size(); ++i) {
    const bool is_low = view.what[i] == What::kStanding && depths[i].ray(1) > 0.04;
    if (is_low && view.places[i].x == kColumn) depths[i].against_road = -5.0;
  }
  const auto ratios = RoadLogRatios(road, depths, view.places, kImage, nullptr);
  EXPECT_EQ(ShareAbove(view, ratios, What::kStanding, 1.0), 0.0);

  for (size_t i = 0; i < depths.size(); ++i) {
    if (view.what[i] == What::kStanding && view.places[i].x != kColumn) depths[i].valid = false;
  }
  const auto alone = RoadLogRatios(road, depths, view.places, kImage, nullptr);
  EXPECT_GT(ShareAbove(view, alone, What::kStanding, 2.0), 0.0);
}

TEST(RoadContact, ASurfaceTallerThanAVehicleIsNotMarked) {
  for (const double top : {-0.1, -0.2}) {
    View view = MakeView(0.1);
    for (size_t i = 0; i < view.pairs.size(); ++i) {
      const Eigen::Vector3d ray = view.camera.Ray(view.places[i].x, view.places[i].y);
      if (!(ray(0) > 0.2 && ray(0) < 0.35 && ray(1) > top && ray(1) < 0.0)) continue;
      Approach(15.0, 2.0 * kTravel, i, view);
      view.what[i] = What::kOncoming;
    }
    const auto [shown, depths, road] = LookAt(view);
    const auto ratios = RoadLogRatios(road, depths, view.places, kImage, nullptr);
    const double share = ShareAbove(view, ratios, What::kOncoming, 1.0);
    if (top > -0.15) {
      EXPECT_GT(share, 0.8);
    } else {
      EXPECT_LT(share, 0.02);
    }
  }
}

TEST(RoadContact, ACarIsMarkedThoughFlowIsSmoothBetweenItAndTheHouse) {
  auto [view, depths, road] = LookAt(MakeView(0.1));
  constexpr double kCar = 2.0 * kTravel / 15.0, kHouse = kTravel / 60.0;
  constexpr int kSmeared = 3;  // places around the car
  const int columns = (kImage.width + kStep - 3) / kStep;
  const int rows = static_cast<int>(depths.size()) / columns;
  for (int i = 0; i < rows * columns; ++i) {
    if (view.what[i] != What::kHouse) continue;
    int apart = kSmeared + 1;
    for (int y = -kSmeared; y <= kSmeared; ++y) {
      for (int x = -kSmeared; x <= kSmeared; ++x) {
        const int row = i / columns + y, column = i % columns + x;
        if (row < 0 || row >= rows || column < 0 || column >= columns) continue;
        if (view.what[row * columns + column] != What::kOncoming) continue;
        apart = std::min(apart, std::max(std::abs(x), std::abs(y)));
      }
    }
    if (apart > kSmeared) continue;
    depths[i].value = kCar + (kHouse - kCar) * apart / (kSmeared + 1.0);
    depths[i].deviation = 0.2 * kCar;
  }
  const auto ratios = RoadLogRatios(road, depths, view.places, kImage, nullptr);
  EXPECT_GT(ShareAbove(view, ratios, What::kOncoming, 2.0), 0.8);
}

// A road's texture at a place of it, metres; smooth, of a wave length of some pixels.
double Texture(double across, double along) {
  return 120.0 + 50.0 * std::sin(25.0 * across) * std::cos(9.0 * along) +
         30.0 * std::sin(11.0 * across + 5.0 * along);
}

TEST(RoadContact, PicturesTellRoadFromPlacesThatWereCarriedAlong) {
  std::vector<bool> is_carried;
  const View view = WithBleedingFlow(is_carried);
  cv::Mat1b before(kImage), now(kImage);
  for (int y = 0; y < kImage.height; ++y) {
    for (int x = 0; x < kImage.width; ++x) {
      const Eigen::Vector3d ray = view.camera.Ray(x, y);
      const double depth = ray(1) > 1e-3 ? kHeight / ray(1) : 1e3;
      now(y, x) = static_cast<uint8_t>(Texture(depth * ray(0), depth));
      // The camera was kTravel further back: a place at depth d then is one at d - kTravel now.
      before(y, x) = static_cast<uint8_t>(Texture(depth * ray(0), depth - kTravel));
    }
  }
  std::vector<cv::Point2f> befores;
  for (const PointPair& pair : view.pairs) {
    befores.emplace_back(static_cast<float>(pair.x1), static_cast<float>(pair.y1));
  }
  const PhotometricSupport pictures(before, now, befores, view.places);
  auto [shown, depths, road] = LookAt(view);
  CompareWithRoad(road, view.camera, view.pose, pictures, view.pairs, depths);
  int carried = 0, seen = 0;
  for (size_t i = 0; i < depths.size(); ++i) {
    if (!depths[i].valid || !std::isfinite(depths[i].against_road)) continue;
    if (is_carried[i]) {
      ++carried;
      seen += depths[i].against_road < -1.0 ? 1 : 0;
    } else if (view.what[i] == What::kRoad) {
      EXPECT_LT(depths[i].against_road, 3.0) << view.places[i];  // not seen to be anything else
    }
  }
  ASSERT_GT(carried, 20);
  EXPECT_GT(seen, 0.6 * carried);
}

// A car that seems a fifth too far: by the plane, which is right to 0.07, it moves; it may stand
// where the road around it lies a seventh lower.
TEST(RoadContact, TheRoadAroundAnObjectIsWhatItStandsOn) {
  auto [view, depths, road] = LookAt(MakeView(0.05));
  for (const double lower : {1.0, 0.86}) {
    auto moved = depths;
    for (size_t i = 0; i < moved.size(); ++i) {
      const bool is_near = moved[i].ray(1) > 0.03;
      if (view.what[i] == What::kRoad && is_near) moved[i].value *= lower;
      if (view.what[i] == What::kStanding) moved[i].value *= 0.8;
    }
    const auto ratios = RoadLogRatios(road, moved, view.places, kImage, nullptr);
    const double share = ShareAbove(view, ratios, What::kStanding, 1.5);
    if (lower == 1.0) {
      EXPECT_GT(share, 0.5);
    } else {
      EXPECT_LT(share, 0.05);
    }
  }
}

// The same car, where most places fit the road only because their depth is hardly known.
TEST(RoadContact, PlacesOfUnknownDepthDoNotMakeTheRoadUneven) {
  auto [view, depths, road] = LookAt(MakeView(0.05));
  for (size_t i = 0; i < depths.size(); ++i) {
    if (view.what[i] == What::kStanding) depths[i].value *= 0.8;
    if (view.what[i] != What::kRoad || i % 5 > 2) continue;
    const double at = road.At(depths[i].ray);
    depths[i].value = (i % 2 == 0 ? 0.4 : 1.6) * at;
    depths[i].deviation = 0.5 * at;
  }
  const auto ratios = RoadLogRatios(road, depths, view.places, kImage, nullptr);
  EXPECT_GT(ShareAbove(view, ratios, What::kStanding, 1.5), 0.5);
}

TEST(RoadContact, PlacesThatAreNoNumbersSayNothing) {
  View view = MakeView(0.1);
  for (size_t i = 0; i < view.pairs.size(); i += 7) view.pairs[i].x1 = std::nan("");
  const auto [shown, depths, road] = LookAt(view);
  const auto ratios = RoadLogRatios(road, depths, view.places, kImage, nullptr);
  for (size_t i = 0; i < ratios.size(); ++i) {
    EXPECT_TRUE(std::isfinite(ratios[i])) << i;
    if (i % 7 == 0) {
      EXPECT_EQ(ratios[i], 0.0) << i;
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
