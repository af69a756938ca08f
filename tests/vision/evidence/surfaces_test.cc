#include "vision/evidence/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <vector>

namespace egosieve::vision {
namespace {

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
      InverseDepth depth;
      depth.valid = true;
      depth.value = inverse_depth(row, column);
      depth.deviation = kDeviation;
      points.depths.push_back(depth);
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
