#include "vision/labelling/pattern_places.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace egosieve::vision {
namespace {

constexpr int kWidth = 320, kHeight = 180;

cv::Mat1b Texture(int seed) {
  cv::RNG random(seed);
  cv::Mat1b noise(kHeight, kWidth);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, noise, {}, 2.0);
  cv::normalize(noise, noise, 0, 255, cv::NORM_MINMAX);
  return noise;
}

// One scene, with the pattern's own picture from column `first` on.
PatternPlaces PlacesOf(int first) {
  const cv::Mat1b pattern = Texture(1);
  cv::Mat1f median;
  SmoothPicture(ReducedPicture(pattern)).convertTo(median, CV_32F);
  const FixedPattern fixed(median, {});
  cv::Mat1b picture = Texture(2);
  pattern.colRange(first, kWidth).copyTo(picture.colRange(first, kWidth));
  return PatternPlaces(&fixed, picture);
}

TEST(PatternPlaces, AFifthOfThePictureIsFixed) {
  const PatternPlaces places = PlacesOf(256);
  EXPECT_TRUE(places.Contain({300, 90}));
  EXPECT_FALSE(places.Contain({100, 90}));
}

// A camera that stands where it stood for most of the drive sees the median of its pictures.
TEST(PatternPlaces, MostOfThePictureIsTheScene) {
  EXPECT_TRUE(PlacesOf(0).empty());
  EXPECT_TRUE(PlacesOf(100).empty());
}

}  // namespace
}  // namespace egosieve::vision
