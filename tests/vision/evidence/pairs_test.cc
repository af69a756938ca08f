#include <cmath>
#include <limits>
#include <random>

#include "gtest/gtest.h"
#include "vision/evidence/calibrated_pairs.h"
#include "vision/evidence/residual_scale.h"

namespace egosieve::vision {
namespace {

constexpr double kFocal = 600.0;
const Pinhole kCamera = Pinhole::Of({640, 360}, kFocal);
const cv::Size kSize(640, 360);

// Straight ahead; places right of the middle have horizontal epipolar lines.
CalibratedPair Pair(int pictures, double noise_pixels) {
  CalibratedPair pair;
  pair.pictures = pictures;
  pair.motion.found = true;
  pair.motion.translation = Eigen::Vector3d(0.0, 0.0, pictures > 0 ? -1.0 : 1.0);
  pair.motion.mean_parallax = 0.03 * std::abs(pictures);
  pair.motion.noise_pixels = noise_pixels;
  pair.motion.noise = noise_pixels / kFocal;
  pair.motion.static_share = 0.9;
  pair.motion.moving_scale = 20.0 / kFocal;
  return pair;
}

// A place 100 px right of the middle that moves by (along, across) pixels a picture.
PointPair Place(double along, double across, int pictures) {
  const double x = kCamera.Project({100.0 / kFocal, 0.0, 1.0})(0);
  const double y = kCamera.Project({0.0, 0.0, 1.0})(1);
  return {x, y, x + along * pictures, y + across * pictures};
}

double LogRatio(const CalibratedPair& pair, const PointPair& place) {
  CalibratedPair alone = pair;
  alone.places = {place};
  return *CalibratedLogRatios({alone}, kCamera)[0][0];
}

TEST(CalibratedPairs, OnePairSaysWhatItsLikelihoodSays) {
  const CalibratedPair pair = Pair(5, 0.4);
  const PointPair place = Place(1.0, 0.3, 5);
  const PairLikelihood likelihood = LikelihoodOf(pair.motion, kCamera, place);
  EXPECT_DOUBLE_EQ(LogRatio(pair, place), likelihood.log_moving - likelihood.log_static);
  EXPECT_EQ(LogRatio(pair, Place(1.0, 20.0, 5)), 12.0);
}

TEST(CalibratedPairs, ThatASlowMoverHardlyMovesInAShortPairDoesNotSpeakAgainstIt) {
  // 0.6 px a picture off the line: nothing between two pictures, much between six.
  CalibratedPair longer = Pair(5, 0.4), shorter = Pair(1, 0.3), behind = Pair(-1, 0.3);
  longer.places = {Place(1.0, 0.6, 5)};
  shorter.places = {Place(1.0, 0.6, 1)};
  behind.places = {Place(1.0, 0.6, -1)};
  EXPECT_LT(LogRatio(shorter, shorter.places[0]), -3.0);
  // Whatever their order.
  const auto ratios = CalibratedLogRatios({shorter, longer, behind}, kCamera);
  EXPECT_GT(*ratios[1][0], 8.0);
  EXPECT_GT(*ratios[0][0], 0.0);
  EXPECT_GT(*ratios[2][0], 0.0);
  // It still does where the drift would have to turn round.
  shorter.places = {Place(1.0, -0.6, 1)};
  EXPECT_LT(*CalibratedLogRatios({shorter, longer}, kCamera)[0][0], -2.0);
}

TEST(CalibratedPairs, WhatStandsStillIsSaidOnce) {
  CalibratedPair longer = Pair(5, 0.4), shorter = Pair(1, 0.3);
  longer.places = {Place(1.0, 0.0, 5)};
  shorter.places = {Place(1.0, 0.0, 1)};
  const auto ratios = CalibratedLogRatios({longer, shorter}, kCamera);
  EXPECT_LT(*ratios[0][0], -3.0);
  // log(1/2), and a little for the spread of the drift.
  EXPECT_GT(*ratios[1][0], -1.0);
  EXPECT_LT(*ratios[1][0], 0.0);
}

TEST(CalibratedPairs, APlaceThatThePairDoesNotKnowIsJudgedByTheNext) {
  CalibratedPair longer = Pair(5, 0.4), shorter = Pair(1, 0.3);
  const double nowhere = std::numeric_limits<double>::quiet_NaN();
  longer.places = {{nowhere, nowhere, nowhere, nowhere}};
  shorter.places = {Place(1.0, 0.6, 1)};
  const auto ratios = CalibratedLogRatios({longer, shorter}, kCamera);
  EXPECT_FALSE(ratios[0][0].has_value());
  EXPECT_DOUBLE_EQ(*ratios[1][0], LogRatio(shorter, shorter.places[0]));
}

TEST(CalibratedPairs, PicturesThatLookAlikeEverywhereSayNothingOfMoving) {
  CalibratedPair pair = Pair(5, 0.4);
  pair.places = {Place(1.0, 3.0, 5), Place(1.0, 0.0, 5)};
  const cv::Mat blank(kSize, CV_8UC1, cv::Scalar(90));
  const cv::Point2f place(static_cast<float>(pair.places[0].x1),
                          static_cast<float>(pair.places[0].y1));
  pair.support.emplace(blank, blank, std::vector<cv::Point2f>{place},
                       std::vector<cv::Point2f>{place});
  const auto ratios = CalibratedLogRatios({pair}, kCamera);
  EXPECT_EQ(*ratios[0][0], 0.0);
  EXPECT_DOUBLE_EQ(*ratios[0][1], LogRatio(Pair(5, 0.4), pair.places[1]));
}

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
