#include "vision/features/patch_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "tests/vision/features/textured_image.h"

namespace egosieve::vision {
namespace {

using testing::TexturedImage;

constexpr int kSpacing = 5, kPatchSize = 44;
constexpr int kInside = 10;  // what is seen around a place is of the patch

struct Pictures {
  cv::Mat from = TexturedImage(400, 240, 1), to = TexturedImage(400, 240, 1);

  // A patch of other texture that moves over the background.
  void AddPatch(cv::Point corner, cv::Point2f way, uint64_t seed) {
    const cv::Mat texture = TexturedImage(kPatchSize, kPatchSize, seed);
    const auto put = [&](cv::Mat& picture, cv::Point2f at) {
      const cv::Mat motion = (cv::Mat_<double>(2, 3) << 1, 0, at.x, 0, 1, at.y);
      cv::warpAffine(texture, picture, motion, picture.size(), cv::INTER_CUBIC,
                     cv::BORDER_TRANSPARENT);
    };
    put(from, corner);
    put(to, cv::Point2f(corner) + way);
  }
};

std::vector<cv::Point2f> PlacesIn(const cv::Rect& area) {
  std::vector<cv::Point2f> places;
  for (int y = area.y; y < area.br().y; y += kSpacing) {
    for (int x = area.x; x < area.br().x; x += kSpacing) places.emplace_back(x, y);
  }
  return places;
}

std::vector<cv::Point2f> PlacesOfPatch(cv::Point corner) {
  const int side = kPatchSize - 2 * kInside;
  return PlacesIn({corner.x + kInside, corner.y + kInside, side, side});
}

int CountFound(const cv::Mat& from, const cv::Mat& to, const std::vector<cv::Point2f>& places) {
  int count = 0;
  for (const auto& there : SearchPatches(from, to, places, kSpacing)) count += there.has_value();
  return count;
}

TEST(SearchPatches, FindsWhatIsSmallAndFast) {
  const cv::Point corner(170, 100);
  for (const cv::Point2f way : {cv::Point2f(40.0f, 16.0f),
                                {-39.6f, -15.3f},
                                {33.4f, -9.5f},
                                {-12.7f, 15.6f},
                                {0.0f, -16.0f}}) {
    Pictures pictures;
    pictures.AddPatch(corner, way, 2);
    const std::vector<cv::Point2f> places = PlacesOfPatch(corner);
    const auto found = SearchPatches(pictures.from, pictures.to, places, kSpacing);
    ASSERT_EQ(found.size(), places.size());
    size_t count = 0;
    for (size_t i = 0; i < places.size(); ++i) {
      if (!found[i]) continue;
      ++count;
      EXPECT_LT(cv::norm(*found[i] - places[i] - way), 0.3) << way << " at " << places[i];
    }
    EXPECT_GT(count, 0.8 * places.size()) << way;
  }
}

TEST(SearchPatches, BlankAndRepetitiveTextureHasNoPlace) {
  const std::vector<cv::Point2f> places = PlacesIn({100, 60, 200, 120});
  const cv::Mat blank(240, 400, CV_8UC1, cv::Scalar(120));
  EXPECT_EQ(CountFound(blank, blank, places), 0);
  const auto periodic = [](double x0, double y0) {
    cv::Mat1b picture(240, 400);
    for (int y = 0; y < picture.rows; ++y) {
      for (int x = 0; x < picture.cols; ++x) {
        constexpr double kWave = 2.0 * CV_PI / 20.0;
        picture(y, x) = cv::saturate_cast<uint8_t>(120.0 + 50.0 * std::sin(kWave * (x - x0)) +
                                                   50.0 * std::sin(kWave * (y - y0)));
      }
    }
    return picture;
  };
  cv::RNG random(5);
  const auto with_noise = [&](cv::Mat1b picture, double levels) {
    cv::Mat1s noisy;
    cv::Mat1s noise(picture.size());
    random.fill(noise, cv::RNG::NORMAL, 0.0, levels);
    cv::add(picture, noise, noisy, cv::noArray(), CV_16S);
    noisy.convertTo(picture, CV_8U);
    return picture;
  };
  for (const double levels : {0.0, 0.5, 1.0}) {
    EXPECT_EQ(
        CountFound(with_noise(periodic(0, 0), levels), with_noise(periodic(6, 4), levels), places),
        0)
        << levels;
  }
}

TEST(SearchPatches, WhatLeavesThePictureHasNoPlace) {
  for (const cv::Point corner : {cv::Point(170, -6), {170, 240 - kPatchSize + 6}}) {
    Pictures pictures;
    const float way = corner.y < 0 ? -40.0f : 40.0f;
    pictures.AddPatch(corner, {10.0f, way}, 2);
    EXPECT_EQ(CountFound(pictures.from, pictures.to, PlacesOfPatch(corner)), 0) << corner;
  }
  const Pictures still;
  EXPECT_EQ(CountFound(still.from, still.to, {{-4, 100}, {200, -4}, {200, 239}, {399, 239}}), 0);
}

// The reach sideways ends at the picture's edge.
TEST(SearchPatches, FindsWhatLiesNearTheSides) {
  for (const auto& [corner, way] : {std::pair(cv::Point(4, 100), cv::Point2f(30.0f, 6.0f)),
                                    {{400 - kPatchSize - 4, 100}, {-30.0f, 6.0f}}}) {
    Pictures pictures;
    pictures.AddPatch(corner, way, 2);
    const std::vector<cv::Point2f> places = PlacesOfPatch(corner);
    const auto found = SearchPatches(pictures.from, pictures.to, places, kSpacing);
    size_t count = 0;
    for (size_t i = 0; i < places.size(); ++i) {
      count += found[i] && cv::norm(*found[i] - places[i] - way) < 0.3;
    }
    EXPECT_GT(count, 0.8 * places.size()) << corner;
  }
}

TEST(SearchPatches, OneAloneIsNotBelieved) {
  const cv::Point corner(170, 100);
  Pictures pictures;
  pictures.AddPatch(corner, {30.0f, 8.0f}, 2);
  const std::vector<cv::Point2f> places = PlacesOfPatch(corner);
  ASSERT_GT(CountFound(pictures.from, pictures.to, places), 10);
  for (const cv::Point2f place : places) {
    EXPECT_EQ(CountFound(pictures.from, pictures.to, {place}), 0) << place;
  }
  EXPECT_EQ(CountFound(pictures.from, pictures.to, {}), 0);
}

}  // namespace
}  // namespace egosieve::vision
