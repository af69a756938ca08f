#include "vision/features/flow_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/testing/status.h"
#include "tests/vision/features/textured_image.h"

namespace egosieve::vision {
namespace {

using testing::TexturedImage;

constexpr double kShiftX = 4.25, kShiftY = -2.5;

cv::Mat Shifted(const cv::Mat& image) {
  const cv::Mat map = (cv::Mat_<double>(2, 3) << 1, 0, kShiftX, 0, 1, kShiftY);
  cv::Mat result;
  cv::warpAffine(image, result, map, image.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return result;
}

TEST(TrackGrid, RecoversAShiftToAFractionOfAPixelFromEitherSide) {
  const cv::Mat first = TexturedImage(320, 200, 1), second = Shifted(first);
  const auto flow = Value(ComputeFlow(first, second, FlowQuality::kFast));
  for (const bool anchor_second : {false, true}) {
    const TrackedGrid grid = TrackGrid(flow, first, second, anchor_second, {});
    EXPECT_EQ(grid.point_count, 64 * 40);
    EXPECT_GT(grid.agreeing_count, 0.85 * grid.point_count);
    ASSERT_EQ(grid.pairs.size(), grid.is_textured.size());
    int near = 0;
    for (const PointPair& pair : grid.pairs) {
      const double whole = anchor_second ? pair.x2 : pair.x1;
      EXPECT_EQ(whole, std::floor(whole));
      near += std::hypot(pair.x2 - pair.x1 - kShiftX, pair.y2 - pair.y1 - kShiftY) < 0.3;
    }
    EXPECT_GT(near, 0.95 * grid.pairs.size());
  }
}

TEST(TrackGrid, DropsWhatThePicturesContradict) {
  const cv::Mat first = TexturedImage(320, 200, 1);
  cv::Mat second = Shifted(first);
  // Something that was not there before.
  TexturedImage(80, 80, 9).copyTo(second(cv::Rect(120, 60, 80, 80)));
  const auto flow = ComputeFlow(first, second, FlowQuality::kFast);
  const TrackedGrid grid = TrackGrid(*flow, first, second, true, {});
  int inside = 0;
  for (const PointPair& pair : grid.pairs) {
    inside += pair.x2 > 130 && pair.x2 < 190 && pair.y2 > 70 && pair.y2 < 130;
  }
  EXPECT_LT(inside, 12 * 12 / 2) << "of 144 grid points inside";
  EXPECT_GT(grid.agreeing_count, grid.point_count / 2);
}

TEST(TrackGrid, BlankPicturesAreNotTextured) {
  const cv::Mat blank(120, 160, CV_8U, cv::Scalar(128));
  const auto flow = Value(ComputeFlow(blank, blank, FlowQuality::kUltrafast));
  const TrackedGrid grid = TrackGrid(flow, blank, blank, true, {});
  EXPECT_EQ(grid.textured_count, 0);
  EXPECT_EQ(grid.agreeing_count, 0);
  EXPECT_GT(grid.point_count, 0);
}

TEST(ComputeFlow, WrongImagesAreErrors) {
  const cv::Mat a = TexturedImage(64, 64, 1);
  EXPECT_FALSE(ComputeFlow(a, TexturedImage(64, 65, 1), FlowQuality::kFast).ok());
  EXPECT_FALSE(ComputeFlow(cv::Mat(), cv::Mat(), FlowQuality::kFast).ok());
  EXPECT_FALSE(
      ComputeFlow(a(cv::Rect(0, 0, 15, 64)), a(cv::Rect(0, 0, 15, 64)), FlowQuality::kFast).ok());
  FlowGridOptions options;
  options.contradiction = 0.9;  // above agreement
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.error_floor = NAN;
  EXPECT_FALSE(options.Validate().ok());
}

TEST(SampleField, BilinearAndClamped) {
  cv::Mat field(2, 2, CV_32FC2);
  field.at<cv::Point2f>(0, 0) = {0, 0};
  field.at<cv::Point2f>(0, 1) = {4, 0};
  field.at<cv::Point2f>(1, 0) = {0, 8};
  field.at<cv::Point2f>(1, 1) = {4, 8};
  EXPECT_EQ(SampleField(field, {0.5F, 0.25F}), cv::Point2f(2, 2));
  EXPECT_EQ(SampleField(field, {-3, 99}), cv::Point2f(0, 8));
  const cv::Mat single(1, 1, CV_32FC2, cv::Scalar(3, 5));
  EXPECT_EQ(SampleField(single, {0.7F, 0.7F}), cv::Point2f(3, 5));
}

}  // namespace
}  // namespace egosieve::vision
