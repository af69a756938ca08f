#include "vision/frame/equalization.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace egosieve::vision {
namespace {

// A dark picture: luminance between 10 and 60, blue twice red.
cv::Mat DarkPicture() {
  cv::Mat image(64, 96, CV_8UC3);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const int v = 10 + (x + y) % 40;
      image.at<cv::Vec3b>(y, x) = cv::Vec3b(2 * v, v, v);
    }
  }
  return image;
}

double LuminanceRange(const cv::Mat& image) {
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  double low, high;
  cv::minMaxLoc(grey, &low, &high);
  return high - low;
}

TEST(EqualizeLuminance, NoneReturnsTheSamePixels) {
  const cv::Mat image = DarkPicture();
  EXPECT_EQ(cv::norm(EqualizeLuminance(image, {}), image, cv::NORM_INF), 0.0);
}

TEST(EqualizeLuminance, OpensDarkPicturesAndLeavesTheInputAlone) {
  const cv::Mat image = DarkPicture();
  const cv::Mat before = image.clone();
  for (const Equalization method : {Equalization::kGlobal, Equalization::kClahe}) {
    EqualizationOptions options;
    options.method = method;
    const cv::Mat result = EqualizeLuminance(image, options);
    ASSERT_EQ(result.type(), CV_8UC3);
    EXPECT_GT(LuminanceRange(result), 1.5 * LuminanceRange(image));
    EXPECT_EQ(cv::norm(image, before, cv::NORM_INF), 0.0);
  }
}

// Adding a constant shifts the histogram and leaves its shape: equalisation must undo it.
TEST(EqualizeLuminance, GlobalTakesOutAChangeOfLight) {
  EqualizationOptions options;
  options.method = Equalization::kGlobal;
  cv::Mat grey;
  cv::cvtColor(DarkPicture(), grey, cv::COLOR_BGR2GRAY);
  const cv::Mat brighter = grey + 50;
  EXPECT_EQ(cv::norm(EqualizeLuminance(grey, options), EqualizeLuminance(brighter, options),
                     cv::NORM_INF),
            0.0);
}

TEST(EqualizationOptions, NonsenseIsRefused) {
  EqualizationOptions options;
  options.clahe_clip_limit = std::nan("");
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.clahe_tiles = 0;
  EXPECT_FALSE(options.Validate().ok());
}

}  // namespace
}  // namespace egosieve::vision
