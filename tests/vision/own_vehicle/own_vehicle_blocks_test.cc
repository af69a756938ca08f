#include "vision/own_vehicle/own_vehicle_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace egosieve::vision {
namespace {

const cv::Size kSize(320, 160);
const cv::Rect kBonnet(64, 112, 192, 48);

// Smooth noise, the same for the same place.
double Texture(double x, double y) {
  return 128 + 40 * std::sin(0.21 * x + 0.05 * y) + 35 * std::sin(0.13 * y - 0.17 * x + 1) +
         30 * std::sin(0.29 * y + 0.03 * x + 2);
}

// A world that is shifted by (x, y), and a bonnet in front of it that is not.
cv::Mat Picture(double x, double y, bool bonnet, uint64_t seed) {
  std::mt19937_64 random(seed);
  cv::Mat image(kSize, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const bool own = bonnet && kBonnet.contains({u, v});
      const double value = own ? Texture(3 * u + 500, 2 * v) : Texture(u - x, v - y);
      image.at<uint8_t>(v, u) =
          cv::saturate_cast<uint8_t>(value + static_cast<double>(random() % 5) - 2);
    }
  }
  return image;
}

WorldMotion Shift(double x, double y) {
  WorldMotion motion;
  motion.homography << 1, 0, x, 0, 1, y, 0, 0, 1;
  return motion;
}

// Share of the blocks' centres that are flagged inside (or outside) the bonnet, one block of
// margin.
double FlaggedShare(const OwnVehicleBlocks& state, bool inside) {
  int flagged = 0, count = 0;
  for (int y = 8; y < kSize.height; y += 16) {
    for (int x = 8; x < kSize.width; x += 16) {
      const cv::Rect grown(kBonnet.x - 16, kBonnet.y - 16, kBonnet.width + 32, kBonnet.height + 32);
      const cv::Rect shrunk(kBonnet.x + 16, kBonnet.y + 16, kBonnet.width - 32,
                            kBonnet.height - 16);
      if (inside ? !shrunk.contains({x, y}) : grown.contains({x, y})) continue;
      ++count;
      flagged += IsOwnVehicle(state, cv::Point2f(x, y)) ? 1 : 0;
    }
  }
  return static_cast<double>(flagged) / count;
}

// Pitch and yaw back and forth; `moves` false: the camera stands.
OwnVehicleBlocks Drive(int frames, bool bonnet, double amplitude, OwnVehicleBlocks state = {}) {
  const auto sway = [&](int t) {
    return Eigen::Vector2d(2 * amplitude * std::sin(1.3 * t), amplitude * std::sin(2.1 * t));
  };
  for (int t = 0; t < frames; ++t) {
    const Eigen::Vector2d at = sway(t), step = at - sway(t - 1);
    const WorldMotion motion = Shift(step(0), step(1));
    const int64_t index = t + (state.images.empty() ? 0 : state.images.back().index + 1 - t);
    LearnOwnVehicleBlocks(Picture(at(0), at(1), bonnet, t), index, 1, &motion, {}, state);
  }
  return state;
}

TEST(OwnVehicle, ABonnetIsFoundAndTheWorldIsNot) {
  const OwnVehicleBlocks state = Drive(60, true, 1.0);
  EXPECT_GT(FlaggedShare(state, true), 0.8);
  EXPECT_EQ(FlaggedShare(state, false), 0.0);
}

TEST(OwnVehicle, NothingIsFoundWithoutOne) {
  const OwnVehicleBlocks state = Drive(60, false, 1.0);
  EXPECT_EQ(FlaggedShare(state, true), 0.0);
  EXPECT_EQ(FlaggedShare(state, false), 0.0);
}

TEST(OwnVehicle, NothingIsLearntWhileTheCameraStands) {
  const OwnVehicleBlocks state = Drive(80, true, 0.0);
  EXPECT_EQ(FlaggedShare(state, true), 0.0);
  EXPECT_EQ(FlaggedShare(state, false), 0.0);
}

// What a camera follows by hand stays near its place, but not in it.
TEST(OwnVehicle, AFollowedObjectIsNotTheOwnVehicle) {
  OwnVehicleBlocks state;
  for (int t = 0; t < 80; ++t) {
    const auto world = [](int k) { return Eigen::Vector2d(1.5 * k, 0.5 * std::sin(k)); };
    const auto object = [](int k) { return Eigen::Vector2d(1.2 * std::sin(0.9 * k), 0.0); };
    cv::Mat image = Picture(world(t)(0), world(t)(1), false, t);
    const cv::Rect place(112, 48, 96, 64);
    Picture(object(t)(0), object(t)(1), false, t + 1000)(place).copyTo(image(place));
    const Eigen::Vector2d step = world(t) - world(t - 1);
    const WorldMotion motion = Shift(step(0), step(1));
    LearnOwnVehicleBlocks(image, t, 1, &motion, {}, state);
  }
  for (int y = 0; y < kSize.height; y += 16) {
    for (int x = 0; x < kSize.width; x += 16) EXPECT_FALSE(IsOwnVehicle(state, cv::Point2f(x, y)));
  }
}

// Straight ahead over a road, in a picture without any texture: what places say. `still`: areas
// that keep their place, but for a shake; `blank`: areas without places.
OwnVehicleBlocks DriveOverRoad(int frames, const std::vector<cv::Rect>& still,
                               const std::vector<cv::Rect>& blank) {
  WorldMotion motion;
  motion.has_line = true;
  motion.camera = Pinhole::Of(kSize, 210);
  motion.pose.outcome = PoseOutcome::kFound;
  motion.pose.translation = -Eigen::Vector3d::UnitZ();
  motion.road.found = true;
  motion.road.m = Eigen::Vector3d(0.0, 0.9, 0.0);
  const auto is_in = [](const std::vector<cv::Rect>& areas, int x, int y) {
    return std::any_of(areas.begin(), areas.end(), [&](const cv::Rect& area) {
      return area.contains({x, y});
    });
  };
  OwnVehicleBlocks state;
  const cv::Mat picture(kSize, CV_8UC1, cv::Scalar(100));
  for (int t = 0; t < frames; ++t) {
    motion.pairs.clear();
    for (int y = 2; y < kSize.height; y += 4) {
      for (int x = 2; x < kSize.width; x += 4) {
        if (is_in(blank, x, y)) continue;
        if (is_in(still, x, y)) {
          motion.pairs.push_back(
              {x + 0.3, static_cast<double>(y), static_cast<double>(x), y + 0.2});
          continue;
        }
        const Eigen::Vector3d ray = motion.camera.Ray(x, y);
        const double inverse_depth = std::max(0.01, motion.road.At(ray));
        const Eigen::Vector2d before =
            motion.camera.Project(ray + inverse_depth * Eigen::Vector3d::UnitZ());
        motion.pairs.push_back(
            {before(0), before(1), static_cast<double>(x), static_cast<double>(y)});
      }
    }
    LearnOwnVehicleBlocks(picture, t, 1, &motion, {}, state);
  }
  return state;
}

// The bonnet's lower half is blank.
TEST(OwnVehicle, ABonnetBelowTheRoadIsFoundSoonWhateverItMirrors) {
  const cv::Rect car_ahead(112, 88, 64, 16);
  const cv::Rect lower(kBonnet.x, 144, kBonnet.width, 16);
  EXPECT_EQ(FlaggedShare(DriveOverRoad(3, {kBonnet, car_ahead}, {lower}), true), 0.0);
  const OwnVehicleBlocks state = DriveOverRoad(6, {kBonnet, car_ahead}, {lower});
  EXPECT_EQ(FlaggedShare(state, true), 1.0);
  EXPECT_EQ(FlaggedShare(state, false), 0.0);
}

TEST(OwnVehicle, ACarAheadWithRoadBelowItIsNot) {
  const cv::Rect car_ahead(112, 88, 64, 24);
  const OwnVehicleBlocks on_road = DriveOverRoad(60, {car_ahead}, {});
  const OwnVehicleBlocks on_blank_road =
      DriveOverRoad(60, {car_ahead}, {cv::Rect(0, 112, 320, 48)});
  for (const OwnVehicleBlocks& state : {on_road, on_blank_road}) {
    EXPECT_EQ(std::count(state.is_own.begin(), state.is_own.end(), 1), 0);
  }
}

TEST(OwnVehicle, HysteresisKeepsAndAtLastGivesBack) {
  OwnVehicleBlocks state = Drive(60, true, 1.0);
  state = Drive(3, false, 1.0, state);
  EXPECT_GT(FlaggedShare(state, true), 0.8);
  state = Drive(120, false, 1.0, state);
  EXPECT_EQ(FlaggedShare(state, true), 0.0);
}

TEST(OwnVehicle, StateIsBoundedAndStartsAnewWithTheSize) {
  OwnVehicleBlocks state = Drive(20, true, 1.0);
  EXPECT_EQ(state.images.size(), 1U);
  for (const float sum : state.sums) EXPECT_LE(std::abs(sum), OwnVehicleBlocksOptions().limit);
  LearnOwnVehicleBlocks(cv::Mat(100, 60, CV_8UC1, cv::Scalar(9)), 100, 3, nullptr, {}, state);
  EXPECT_EQ(state.images.size(), 1U);
  EXPECT_EQ(state.blocks, cv::Size(4, 7));
  EXPECT_FALSE(IsOwnVehicle(state, {200, 150}));
  EXPECT_FALSE(IsOwnVehicle(state, {std::nanf(""), 1}));
}

TEST(OwnVehicle, OptionsAreChecked) {
  EXPECT_TRUE(OwnVehicleBlocksOptions().Validate().ok());
  EXPECT_FALSE(OwnVehicleBlocksOptions({.on = 1, .off = 2}).Validate().ok());
  EXPECT_FALSE(OwnVehicleBlocksOptions({.memory = 1.0}).Validate().ok());
  EXPECT_FALSE(OwnVehicleBlocksOptions({.noise_floor = std::nan("")}).Validate().ok());
}

}  // namespace
}  // namespace egosieve::vision
