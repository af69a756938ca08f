#include "vision/evidence/calibrated_pairs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

}  // namespace
}  // namespace egosieve::vision
