#include "vision/own_vehicle/windscreen.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace egosieve::vision {
namespace {

constexpr int kWidth = 160, kHeight = 120, kPairs = 20;
constexpr int kStep = 37, kStepOfPair = 3;  // pixels that the world goes by
const cv::Rect kReflection(50, 70, 60, 36);
const cv::Size kSize(kWidth, kHeight);

cv::Mat1f Texture(cv::Size size, uint64_t seed, double deviation) {
  cv::RNG random(seed);
  cv::Mat1f texture(size);
  random.fill(texture, cv::RNG::NORMAL, 0, 1);
  cv::GaussianBlur(texture, texture, {}, 1.2);
  cv::Scalar mean, spread;
  cv::meanStdDev(texture, mean, spread);
  return texture * (deviation / spread[0]);
}

struct Pictures {
  std::vector<cv::Mat1b> firsts, seconds;
};

// A world that goes by, and a reflection, brighter than it and with texture, through which it
// shows; `sway`: pixels to and fro from pair to pair.
Pictures Drive(double sway) {
  const cv::Mat1f world = Texture({kWidth + kStep * kPairs + kStepOfPair, kHeight}, 1, 12.0);
  const cv::Mat1f reflection = Texture(kReflection.size() + cv::Size(8, 8), 2, 16.0) + 60.0;
  Pictures pictures;
  for (int k = 0; k < kPairs; ++k) {
    for (std::vector<cv::Mat1b>* of : {&pictures.firsts, &pictures.seconds}) {
      const int x = kStep * k + (of == &pictures.seconds ? kStepOfPair : 0);
      cv::Mat1f picture = world(cv::Rect(x, 0, kWidth, kHeight)) + 90.0;
      const double shift = 4.0 + sway * std::sin(1.7 * k);
      cv::Mat1f shifted;
      const cv::Mat1d transform = (cv::Mat1d(2, 3) << 1, 0, -shift, 0, 1, -4.0);
      cv::warpAffine(reflection, shifted, transform, kReflection.size(), cv::INTER_LINEAR);
      picture(kReflection) += shifted;
      of->emplace_back(picture);
    }
  }
  return pictures;
}

// A camera that turns by `turn` pixels between the pictures of a pair.
cv::Mat1b Find(const Pictures& pictures, double turn) {
  const Pinhole camera = Pinhole::Of(kSize, 150.0);
  std::vector<PairWorld> worlds;
  for (size_t k = 0; k < pictures.firsts.size(); ++k) {
    PairWorld world;
    world.motion.found = true;
    world.motion.rotation =
        Eigen::AngleAxisd(-turn / 150.0, Eigen::Vector3d::UnitY()).toRotationMatrix();
    world.picture = k;
    worlds.push_back(world);
  }
  const FixedPlaces places = FindFixedPlaces(pictures.firsts, kSize);
  return FindWindscreen(places, pictures.seconds, worlds, camera);
}

double ShareIn(const cv::Mat1b& mask, cv::Rect area) {
  return mask.empty() ? 0.0 : static_cast<double>(cv::countNonZero(mask(area))) / area.area();
}

TEST(Windscreen, AReflectionThroughWhichTheWorldGoesByIsFound) {
  const cv::Mat1b mixed = Find(Drive(0.0), kStepOfPair);
  EXPECT_GT(ShareIn(mixed, kReflection), 0.95);
  EXPECT_LT(ShareIn(mixed, {0, 0, kWidth, 50}), 0.01);
}

TEST(Windscreen, WhatStaysWhileTheWorldStandsStillMayBeWorld) {
  EXPECT_TRUE(Find(Drive(0.0), 0.0).empty());
}

// As a vehicle that is followed does.
TEST(Windscreen, WhatSwaysIsNotOnIt) {
  constexpr int kRim = kFixedPatternWindow + 2;  // where its outline stays
  const cv::Rect inner(kReflection.tl() + cv::Point(kRim, kRim),
                       kReflection.br() - cv::Point(kRim, kRim));
  EXPECT_GT(ShareIn(Find(Drive(0.0), kStepOfPair), inner), 0.95);
  EXPECT_LT(ShareIn(Find(Drive(1.5), kStepOfPair), inner), 0.05);
}

TEST(Windscreen, OnAShakingMountAReflectionThatSwaysIsFound) {
  Pictures pictures = Drive(1.5);
  const cv::Rect bonnet(0, 106, kWidth, kHeight - 106);
  const cv::Mat1f texture = Texture(bonnet.size() + cv::Size(8, 0), 3, 30.0) + 90.0;
  for (std::vector<cv::Mat1b>* of : {&pictures.firsts, &pictures.seconds}) {
    for (int k = 0; k < kPairs; ++k) {
      const double shift = 4.0 + 1.5 * std::sin(1.7 * k);
      cv::Mat1f shifted;
      const cv::Mat1d transform = (cv::Mat1d(2, 3) << 1, 0, -shift, 0, 1, 0);
      cv::warpAffine(texture, shifted, transform, bonnet.size(), cv::INTER_LINEAR);
      shifted.convertTo((*of)[k](bonnet), CV_8U);
    }
  }
  std::vector<PairWorld> worlds;
  for (size_t k = 0; k < pictures.firsts.size(); ++k) {
    PairWorld world;
    world.motion.found = true;
    world.motion.translation = -Eigen::Vector3d::UnitZ();
    world.ground_slope = 0.4;
    world.picture = k;
    worlds.push_back(world);
  }
  const FixedPlaces places = FindFixedOnMount(pictures.firsts, kSize);
  const cv::Mat1b mixed =
      FindWindscreen(places, pictures.seconds, worlds, Pinhole::Of(kSize, 150.0));
  EXPECT_GT(ShareIn(mixed, kReflection), 0.8);
  EXPECT_LT(ShareIn(mixed, {0, 0, kWidth, 50}), 0.01);
}

TEST(Windscreen, AFewPicturesSayNothing) {
  Pictures pictures = Drive(0.0);
  pictures.firsts.resize(kFewestOfDrive - 1);
  pictures.seconds.resize(pictures.firsts.size());
  EXPECT_TRUE(Find(pictures, kStepOfPair).empty());
}

}  // namespace
}  // namespace egosieve::vision
