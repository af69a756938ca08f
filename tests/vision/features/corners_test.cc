#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "gtest/gtest.h"
#include "tests/vision/features/textured_image.h"
#include "vision/features/corner_detector.h"
#include "vision/features/corner_tracks.h"
#include "vision/features/spread.h"

namespace egosieve::vision {
namespace {

TEST(DetectCorners, FindsTheCornersOfARectangleToAPixel) {
  cv::Mat image(80, 100, CV_8U, cv::Scalar(40));
  image(cv::Rect(30, 20, 40, 35)).setTo(200);
  const std::vector<Corner> corners = DetectCorners(image, 1e-4F, 3);
  ASSERT_EQ(corners.size(), 4u);
  for (const cv::Point2f expected :
       {cv::Point2f(30, 20), cv::Point2f(69, 20), cv::Point2f(30, 54), cv::Point2f(69, 54)}) {
    EXPECT_TRUE(std::any_of(corners.begin(), corners.end(), [&](const Corner& corner) {
      return std::hypot(corner.position.x - expected.x, corner.position.y - expected.y) < 1.5;
    })) << expected;
  }
}

TEST(DetectCorners, NothingInFlatOrTinyImages) {
  EXPECT_TRUE(DetectCorners(cv::Mat(50, 50, CV_8U, cv::Scalar(128)), 0.0F, 3).empty());
  EXPECT_TRUE(DetectCorners(cv::Mat(5, 5, CV_8U, cv::Scalar(128)), 0.0F, 3).empty());
}

TEST(SpreadOverGrid, TakesTheStrongestOfEachCellFirst) {
  std::vector<cv::Point2f> positions;
  std::vector<float> responses;
  for (int i = 0; i < 100; ++i) {  // a crowd of strong ones in one corner
    positions.emplace_back(0.1F * i, 5.0F);
    responses.push_back(100.0F + i);
  }
  for (int cell = 1; cell < 10; ++cell) {  // one weak one in each other cell
    positions.emplace_back(20.0F * cell + 10.0F, 10.0F);
    responses.push_back(1.0F);
  }
  const auto chosen = SpreadOverGrid(positions, responses, cv::Size(200, 20), 20, 10);
  ASSERT_EQ(chosen.size(), 10u);
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  EXPECT_EQ(chosen[0], 99) << "the strongest of the crowd";
  for (int cell = 1; cell < 10; ++cell) EXPECT_EQ(chosen[cell], 99 + cell);
  EXPECT_EQ(SpreadOverGrid(positions, responses, cv::Size(200, 20), 20, 1000).size(), 109u);
  EXPECT_TRUE(SpreadOverGrid({}, {}, cv::Size(200, 20), 20, 5).empty());
}

constexpr int kWidth = 320, kHeight = 240, kPictures = 6;
constexpr double kStepX = 1.7, kStepY = -0.6;  // pixels from one picture to the next

std::vector<cv::Mat> MovedPictures() {
  const cv::Mat1b texture = testing::TexturedImage(kWidth, kHeight, 5);
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < kPictures; ++k) {
    const cv::Matx23d shift(1, 0, k * kStepX, 0, 1, k * kStepY);
    cv::Mat1b picture;
    cv::warpAffine(texture, picture, shift, texture.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
    pictures.push_back(picture);
  }
  return pictures;
}

std::vector<CornerTrack> TracksOf(const std::vector<cv::Mat>& pictures) {
  CornerTracker tracker(100);
  for (const cv::Mat& picture : pictures) tracker.Add(picture);
  return tracker.tracks();
}

TEST(CornerTracks, FollowToAFractionOfAPixel) {
  const std::vector<CornerTrack> tracks = TracksOf(MovedPictures());
  ASSERT_GT(tracks.size(), 60u);
  EXPECT_LE(tracks.size(), 100u);
  int whole = 0;
  std::vector<double> errors;  // pixels per picture
  for (const CornerTrack& track : tracks) {
    whole += track.size() == kPictures;
    const cv::Point2f moved = track.back() - track.front();
    const double steps = static_cast<double>(track.size()) - 1.0;
    if (steps < 1.0) continue;
    errors.push_back(std::hypot(moved.x - steps * kStepX, moved.y - steps * kStepY) / steps);
  }
  // The tracker iterates to 0.01 pixels; a track may come back as far off as 0.3.
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.02);
  EXPECT_LT(errors.back(), 0.3);
  EXPECT_GT(whole, 50);
}

TEST(CornerTracks, EndWhereThePlaceIsHidden) {
  std::vector<cv::Mat> pictures = MovedPictures();
  for (int k = 3; k < kPictures; ++k) pictures[k](cv::Rect(0, 0, kWidth / 2, kHeight)).setTo(90);
  int left = 0;
  for (const CornerTrack& track : TracksOf(pictures)) {
    if (track.size() < 3 || track[2].x > kWidth / 2 - 40) continue;
    ++left;
    EXPECT_EQ(track.size(), 3u);
  }
  EXPECT_GT(left, 10);
}

TEST(CornerTracks, TellHowFarThePicturesMoved) {
  CornerTracker tracker(100);
  EXPECT_EQ(tracker.MedianMotion(), 0.0);
  const std::vector<cv::Mat> pictures = MovedPictures();
  for (int k = 0; k < kPictures; ++k) {
    tracker.Add(pictures[k]);
    EXPECT_NEAR(tracker.MedianMotion(), k * std::hypot(kStepX, kStepY), 0.1);
  }
  EXPECT_EQ(tracker.pictures(), kPictures);
}

TEST(CornerTracks, ABlankPictureHasNone) {
  const cv::Mat1b blank(kHeight, kWidth, uint8_t{90});
  EXPECT_TRUE(TracksOf({blank, blank, blank}).empty());
}

}  // namespace
}  // namespace egosieve::vision
