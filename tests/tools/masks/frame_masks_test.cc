#include "tools/masks/frame_masks.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/testing/status.h"
#include "tests/tools/testing/fresh_folder.h"

namespace egosieve::tools {
namespace {

TEST(Dilate, ReachesAsFarAsItSaysAndNoFarther) {
  cv::Mat1b masked(41, 61, uint8_t{0});
  masked(20, 30) = 255;
  cv::Mat1w none;
  Dilate(10, masked, none);
  for (int y = 0; y < masked.rows; ++y) {
    for (int x = 0; x < masked.cols; ++x) {
      const int square = (y - 20) * (y - 20) + (x - 30) * (x - 30);
      EXPECT_EQ(masked(y, x) != 0, square <= 100) << x << "," << y;
    }
  }
}

TEST(Dilate, GivesPixelsTheNumberOfTheNearestMover) {
  cv::Mat1w numbers(20, 40, uint16_t{0});
  numbers(10, 10) = 3;
  numbers(10, 20) = 500;
  cv::Mat1b masked = numbers != 0;
  Dilate(8, masked, numbers);
  EXPECT_EQ(numbers(10, 14), 3);
  EXPECT_EQ(numbers(10, 16), 500);
  EXPECT_EQ(numbers(10, 28), 500);
  EXPECT_EQ(numbers(10, 29), 0);
  EXPECT_EQ(cv::countNonZero((numbers != 0) != (masked != 0)), 0);
}

TEST(Dilate, LeavesAPictureWithoutMoversEmpty) {
  cv::Mat1b masked(8, 8, uint8_t{0});
  cv::Mat1w none;
  Dilate(5, masked, none);
  EXPECT_EQ(cv::countNonZero(masked), 0);
}

TEST(ReadFrameMask, HasTheOwnVehicleWhereItIsWanted) {
  const RunFolder folder = Value(RunFolder::Create(FreshFolder(), false));
  FrameLine line;
  line.width_pixels = 30;
  line.height_pixels = 20;
  cv::Mat1b mask(20, 30, uint8_t{0});
  mask(2, 3) = 255;
  ASSERT_TRUE(CreateFolder(folder.File("masks")).ok());
  cv::imwrite(folder.FrameFile("masks", 0, ".png"), mask);
  FrameMaskOptions options;
  options.ignored = cv::Mat1b(20, 30, uint8_t{0});
  options.ignored(cv::Rect(0, 15, 30, 5)) = 255;
  absl::StatusOr<FrameMask> read = ReadFrameMask(folder, line, options);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(cv::countNonZero(read->masked != mask), 0);
  options.own_vehicle = true;
  read = ReadFrameMask(folder, line, options);
  ASSERT_TRUE(read.ok()) << read.status();
  mask(cv::Rect(0, 15, 30, 5)) = 255;
  EXPECT_EQ(cv::countNonZero(read->masked != mask), 0);

  options.ignored(0, 29) = 255;
  mask(0, 29) = 255;
  read = ReadFrameMask(folder, line, options);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(cv::countNonZero(read->masked != mask), 0);

  line.width_pixels = 31;
  EXPECT_EQ(ReadFrameMask(folder, line, options).status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace egosieve::tools
