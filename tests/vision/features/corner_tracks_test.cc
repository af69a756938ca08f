#include "vision/features/corner_tracks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/vision/features/textured_image.h"

namespace egosieve::vision {
namespace {

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
