#include "vision/own_vehicle/fixed_pattern.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace egosieve::vision {
namespace {

constexpr int kWidth = 120, kHeight = 80;
const cv::Rect kCovered(30, 20, 40, 30);

cv::Mat1b Texture(uint64_t seed) {
  cv::RNG random(seed);
  cv::Mat1b texture(kHeight, kWidth);
  random.fill(texture, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(texture, texture, {}, 1.5);
  return texture;
}

double AgreeingShare(const cv::Mat1b& median, const cv::Mat1b& picture, cv::Rect area) {
  const FixedPattern pattern(SmoothPicture(median), {});
  const cv::Mat1b agreeing = pattern.Agreeing(SmoothPicture(picture));
  return static_cast<double>(cv::countNonZero(agreeing(area))) / area.area();
}

TEST(FixedPattern, AgreesInAnyLight) {
  const cv::Mat1b median = Texture(1);
  cv::Mat1b darker;
  median.convertTo(darker, CV_8U, 0.6, 20.0);
  EXPECT_GT(AgreeingShare(median, darker, {0, 0, kWidth, kHeight}), 0.99);
}

TEST(FixedPattern, DoesNotAgreeWithWhatCoversIt) {
  const cv::Mat1b median = Texture(1);
  cv::Mat1b covered = median.clone();
  Texture(2)(kCovered).copyTo(covered(kCovered));
  const int margin = kFixedPatternWindow / 2;
  const cv::Rect inner(kCovered.x + margin, kCovered.y + margin, kCovered.width - 2 * margin,
                       kCovered.height - 2 * margin);
  EXPECT_LT(AgreeingShare(median, covered, inner), 0.2);  // some windows are alike by chance
  EXPECT_GT(AgreeingShare(median, covered, {80, 0, 40, kHeight}), 0.99);
}

TEST(FixedPattern, DoesNotAgreeWithItselfAPixelAside) {
  const cv::Mat1b median = Texture(1);
  cv::Mat1b aside;
  const cv::Mat1d shift = (cv::Mat1d(2, 3) << 1, 0, 1, 0, 1, 0);
  cv::warpAffine(median, aside, shift, median.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  EXPECT_LT(AgreeingShare(median, aside, {20, 20, 80, 40}), 0.05);
}

}  // namespace
}  // namespace egosieve::vision
