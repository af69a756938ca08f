#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "vision/evidence/calibrated_pairs.h"
#include "vision/evidence/surfaces.h"
#include "vision/trajectory/scatter.h"

namespace egosieve::vision {
namespace {

constexpr double kFocal = 600.0;
const Pinhole kCamera = Pinhole::Of({640, 360}, kFocal);
const cv::Size kSize(640, 360);

// Straight ahead; places right of the middle have horizontal epipolar lines.
CalibratedPair Pair(int pictures, double noise_pixels) {
  CalibratedPair pair{.pictures = pictures};
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

// (SX2), against Student's t of the same deviation between 3 and 27 deviations.
TEST(Scatter, IsADensityWithTheTailsOfStudentsT) {
  double sum = 0.0;
  constexpr double kStep = 0.01;
  for (double z = -200.0; z < 200.0; z += kStep) sum += kStep * std::exp(LogScatterDensity(z));
  EXPECT_NEAR(sum, 1.0, 1e-6);
  for (double z = 3.0; z < 27.0; z *= 1.1) {
    const double student = std::log(2.0 / (M_PI * std::sqrt(3.0))) - 2.0 * std::log1p(z * z / 3.0);
    EXPECT_NEAR(LogScatterDensity(z), student, 2.0) << z;
  }
}

TEST(CalibratedPairs, OfAHandHeldCameraAFewDeviationsAreNoProofOfMotion) {
  CalibratedPair pair = Pair(1, 0.4);
  EXPECT_GT(LogRatio(pair, Place(1.0, 0.4 * 5, 1)), 3.0);
  pair.motion.scatters = true;
  EXPECT_LT(LogRatio(pair, Place(1.0, 0.4 * 5, 1)), 3.0);
  EXPECT_GT(LogRatio(pair, Place(1.0, 0.4 * 10, 1)), 3.0);
  EXPECT_LT(LogRatio(pair, Place(1.0, 0.4 * 10, 1)), 9.0);
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

constexpr int kColumns = 24, kRows = 12, kStep = 5;
constexpr double kDeviation = 0.005;
const cv::Size kImage(kColumns* kStep, kRows* kStep);

// One point a cell, row by row.
struct Points {
  std::vector<cv::Point2f> places;
  std::vector<InverseDepth> depths;
  std::vector<bool> is_part;

  std::vector<int> Surfaces() const { return FindSurfaces({places, kImage}, depths, is_part); }
};

Points PointsOf(const std::function<double(int, int)>& inverse_depth) {
  Points points;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      points.places.emplace_back(column * kStep + 2.0f, row * kStep + 2.0f);
      points.depths.push_back(
          {.valid = true, .value = inverse_depth(row, column), .deviation = kDeviation});
    }
  }
  points.is_part.assign(points.places.size(), true);
  return points;
}

TEST(Raster, TheFirstPlaceOfACellRepresentsIt) {
  std::vector<cv::Point2f> places = PointsOf([](int, int) { return 0.0; }).places;
  places.emplace_back(3.0f, 3.0f);
  places.emplace_back(kImage.width, kImage.height);
  places.emplace_back(kImage.width + 90.0f, -90.0f);
  const Raster raster(places, kImage);
  ASSERT_GE(raster.columns(), kColumns);
  ASSERT_GE(raster.rows(), kRows);
  EXPECT_EQ(raster.At(0, 0), 0);
  EXPECT_EQ(raster.RepresentativeOf({3.0f, 3.0f}), 0);
  // Beyond the border: the nearest cell's.
  EXPECT_EQ(raster.RepresentativeOf({-90.0f, -90.0f}), 0);
  EXPECT_EQ(raster.At(raster.rows() - 1, raster.columns() - 1), kRows * kColumns + 1);
  EXPECT_EQ(raster.RepresentativeOf({1e4f, 1e4f}), kRows * kColumns + 1);
  EXPECT_EQ(raster.At(0, raster.columns() - 1), kRows * kColumns + 2);
}

TEST(Raster, ACellWithoutPlacesHasNoRepresentative) {
  const Raster raster({{2.0f, 2.0f}, {97.0f, 97.0f}}, {100, 100});
  EXPECT_EQ(raster.At(0, 0), 0);
  EXPECT_EQ(raster.At(0, 1), -1);
  EXPECT_EQ(Raster({}, {100, 100}).RepresentativeOf({50.0f, 50.0f}), -1);
}

TEST(Surfaces, AGradientBetweenTwoDepthsDoesNotJoinThem) {
  constexpr int kFirst = 8, kLast = 15;  // the columns that it links
  constexpr double kNear = 0.2, kFar = 0.1;
  Points points = PointsOf([](int, int column) {
    const double share = std::clamp((column - kFirst) / double{kLast - kFirst}, 0.0, 1.0);
    return kNear + share * (kFar - kNear);
  });
  const std::vector<int> surfaces = points.Surfaces();
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const int i = row * kColumns + column;
      if (column <= kFirst) {
        EXPECT_EQ(surfaces[i], surfaces.front());
      }
      if (column >= kLast) {
        EXPECT_EQ(surfaces[i], surfaces.back());
      }
    }
  }
  EXPECT_NE(surfaces.front(), surfaces.back());
  // Any two neighbouring columns by themselves are one.
  for (int column = 1; column < kColumns; ++column) {
    for (size_t i = 0; i < points.is_part.size(); ++i) {
      const int own = static_cast<int>(i) % kColumns;
      points.is_part[i] = own == column - 1 || own == column;
    }
    const std::vector<int> pair = points.Surfaces();
    EXPECT_EQ(*std::max_element(pair.begin(), pair.end()), 0) << column;
  }
}

TEST(Surfaces, NoiseDoesNotDivideASurface) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, kDeviation);
  const Points points = PointsOf([&](int, int) { return 0.15 + noise(random); });
  std::map<int, int> sizes;
  int largest = 0;
  for (const int surface : points.Surfaces()) largest = std::max(largest, ++sizes[surface]);
  EXPECT_GT(largest, 0.98 * kRows * kColumns);
}

TEST(Surfaces, WhatIsNoPartBelongsToNone) {
  constexpr int kWall = 10;
  Points points = PointsOf([](int, int) { return 0.15; });
  for (int row = 0; row < kRows; ++row) points.is_part[row * kColumns + kWall] = false;
  points.places.push_back(points.places.front());  // has another representative
  points.depths.push_back(points.depths.front());
  points.is_part.push_back(true);
  const std::vector<int> surfaces = points.Surfaces();
  for (int i = 0; i < kRows * kColumns; ++i) {
    const int column = i % kColumns;
    EXPECT_EQ(surfaces[i], column == kWall ? -1 : column > kWall) << i;
  }
  EXPECT_EQ(surfaces.back(), -1);
}

// Depths in coarse steps: most edges have an equal.
TEST(Surfaces, DoNotDependOnTheOrderOfThePoints) {
  std::mt19937_64 random(4);
  const Points points =
      PointsOf([&](int, int) { return 0.1 + 0.01 * static_cast<double>(random() % 8); });
  const std::vector<int> expected = points.Surfaces();
  ASSERT_GT(*std::max_element(expected.begin(), expected.end()), 3);
  std::vector<size_t> order(points.places.size());
  std::iota(order.begin(), order.end(), 0);
  for (int k = 0; k < 20; ++k) {
    std::shuffle(order.begin(), order.end(), random);
    Points shuffled;
    for (const size_t i : order) {
      shuffled.places.push_back(points.places[i]);
      shuffled.depths.push_back(points.depths[i]);
      shuffled.is_part.push_back(true);
    }
    const std::vector<int> surfaces = shuffled.Surfaces();
    for (size_t i = 0; i < order.size(); ++i) ASSERT_EQ(surfaces[i], expected[order[i]]);
  }
}

}  // namespace
}  // namespace egosieve::vision
