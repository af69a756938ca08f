#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "gtest/gtest.h"
#include "tests/testing/status.h"
#include "tests/vision/features/textured_image.h"
#include "vision/features/corner_detector.h"
#include "vision/features/corner_tracks.h"
#include "vision/features/flow_grid.h"
#include "vision/features/flow_growth.h"

namespace egosieve::vision {
namespace {

using testing::TexturedImage;
TEST(DetectCorners, FindsTheCornersOfARectangleToAPixel) {
  cv::Mat image(80, 100, CV_8U, cv::Scalar(40));
  image(cv::Rect(30, 20, 40, 35)).setTo(200);
  const std::vector<cv::KeyPoint> corners = DetectCorners(image, 1e-4F, 3);
  ASSERT_EQ(corners.size(), 4u);
  for (const cv::Point2f expected :
       {cv::Point2f(30, 20), cv::Point2f(69, 20), cv::Point2f(30, 54), cv::Point2f(69, 54)}) {
    EXPECT_TRUE(std::any_of(corners.begin(), corners.end(), [&](const cv::KeyPoint& corner) {
      return std::hypot(corner.pt.x - expected.x, corner.pt.y - expected.y) < 1.5;
    })) << expected;
  }
}

TEST(DetectCorners, NothingInFlatOrTinyImages) {
  EXPECT_TRUE(DetectCorners(cv::Mat(50, 50, CV_8U, cv::Scalar(128)), 0.0F, 3).empty());
  EXPECT_TRUE(DetectCorners(cv::Mat(5, 5, CV_8U, cv::Scalar(128)), 0.0F, 3).empty());
}

TEST(SpreadOverGrid, TakesTheStrongestOfEachCellFirst) {
  std::vector<cv::KeyPoint> features;  // with their indices as classes
  for (int i = 0; i < 100; ++i) {      // a crowd of strong ones in one corner
    features.emplace_back(0.1F * i, 5.0F, 1.0F, 0.0F, 100.0F + i, 0, i);
  }
  for (int cell = 1; cell < 10; ++cell) {  // one weak one in each other cell
    features.emplace_back(20.0F * cell + 10.0F, 10.0F, 1.0F, 0.0F, 1.0F, 0, 99 + cell);
  }
  const auto chosen = SpreadOverGrid(features, cv::Size(200, 20), 20, 10);
  ASSERT_EQ(chosen.size(), 10u);
  EXPECT_EQ(chosen[0].class_id, 99) << "the strongest of the crowd";
  for (int cell = 1; cell < 10; ++cell) EXPECT_EQ(chosen[cell].class_id, 99 + cell);
  EXPECT_EQ(SpreadOverGrid(features, cv::Size(200, 20), 20, 1000).size(), 109u);
  EXPECT_TRUE(SpreadOverGrid({}, cv::Size(200, 20), 20, 5).empty());
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
    EXPECT_GT(grid.AgreeingCount(), 0.85 * 64 * 40);
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
  EXPECT_GT(grid.AgreeingCount(), 64 * 40 / 2);
}

TEST(TrackGrid, BlankPicturesAreNotTextured) {
  const cv::Mat blank(120, 160, CV_8U, cv::Scalar(128));
  const auto flow = Value(ComputeFlow(blank, blank, FlowQuality::kUltrafast));
  const TrackedGrid grid = TrackGrid(flow, blank, blank, true, {});
  EXPECT_TRUE(grid.textured.empty());
  EXPECT_FALSE(grid.pairs.empty());
}

TEST(ComputeFlow, WrongImagesAreErrors) {
  const cv::Mat a = TexturedImage(64, 64, 1);
  EXPECT_FALSE(ComputeFlow(a, TexturedImage(64, 65, 1), FlowQuality::kFast).ok());
  EXPECT_FALSE(ComputeFlow(cv::Mat(), cv::Mat(), FlowQuality::kFast).ok());
  EXPECT_FALSE(
      ComputeFlow(a(cv::Rect(0, 0, 15, 64)), a(cv::Rect(0, 0, 15, 64)), FlowQuality::kFast).ok());
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

constexpr int kFlowWidth = 400, kFlowHeight = 240, kSide = 40;
const cv::Point2f kBackground(4.0f, -2.0f), kWay(38.0f, 10.0f);
const cv::Rect kBefore(142, 80, kSide, kSide), kNow(180, 90, kSide, kSide);

cv::Mat Moved(const cv::Mat& image) {
  const cv::Mat map = (cv::Mat_<double>(2, 3) << 1, 0, kBackground.x, 0, 1, kBackground.y);
  cv::Mat result;
  cv::warpAffine(image, result, map, image.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return result;
}

// A small fast square before a background that moves slowly.
struct Scene {
  cv::Mat first = TexturedImage(kFlowWidth, kFlowHeight, 1), second = Moved(first);

  Scene() {
    const cv::Mat mover = TexturedImage(kSide, kSide, 2);
    mover.copyTo(first(kBefore));
    mover.copyTo(second(kNow));
  }
};

FlowPair FlowOfBackground() {
  const auto field = [](cv::Point2f way) {
    return cv::Mat(kFlowHeight, kFlowWidth, CV_32FC2, cv::Scalar(way.x, way.y));
  };
  return {field(kBackground), field(-kBackground)};
}

struct Counts {
  int of_mover = 0, right = 0, of_background = 0, right_background = 0;
};

// Of the nodes of the grid that lies in either picture; of the mover's, those whose patches (8
// pixels wide) do not reach beyond it, 36 of 64.
Counts Count(const Scene& scene, const FlowPair& flow, bool anchor_second) {
  const cv::Rect mover = anchor_second ? kNow : kBefore, other = anchor_second ? kBefore : kNow;
  const cv::Rect inner(mover.x + 4, mover.y + 4, kSide - 8, kSide - 8);
  const TrackedGrid grid = TrackGrid(flow, scene.first, scene.second, anchor_second, {});
  Counts counts;
  for (const PointPair& pair : grid.pairs) {
    const cv::Point2d at =
        anchor_second ? cv::Point2d(pair.x2, pair.y2) : cv::Point2d(pair.x1, pair.y1);
    const cv::Point2d way(pair.x2 - pair.x1, pair.y2 - pair.y1);
    if (inner.contains(at)) {
      ++counts.of_mover;
      counts.right += cv::norm(way - cv::Point2d(kWay)) < 0.5;
    } else if (!mover.contains(at) && !other.contains(at)) {
      ++counts.of_background;
      counts.right_background += cv::norm(way - cv::Point2d(kBackground)) < 0.5;
    }
  }
  return counts;
}

// Both fields lead back everywhere, and follow the background on the mover, too.
TEST(GrowFlow, CorrectsWhatFollowsTheBackground) {
  const Scene scene;
  FlowPair flow = FlowOfBackground();
  ASSERT_GT(GrowFlow(scene.first, scene.second, {}, flow), 2 * 36);
  for (const bool anchor_second : {false, true}) {
    const Counts counts = Count(scene, flow, anchor_second);
    EXPECT_GE(counts.right, 34);
    EXPECT_EQ(counts.of_mover, counts.right);
    EXPECT_GE(counts.right_background, 0.97 * counts.of_background);
  }
}

TEST(GrowFlow, FindsWhatOpticalFlowLoses) {
  const Scene scene;
  auto flow = Value(ComputeFlow(scene.first, scene.second, FlowQuality::kMedium));
  ASSERT_LT(Count(scene, flow, false).right, 8);
  GrowFlow(scene.first, scene.second, {}, flow);
  for (const bool anchor_second : {false, true}) {
    EXPECT_GE(Count(scene, flow, anchor_second).right, 34);
  }
}

TEST(GrowFlow, LeavesAFlowThatHolds) {
  const cv::Mat first = TexturedImage(kFlowWidth, kFlowHeight, 1), second = Moved(first);
  FlowPair flow = FlowOfBackground();
  EXPECT_EQ(GrowFlow(first, second, {}, flow), 0);
  const FlowPair expected = FlowOfBackground();
  EXPECT_EQ(cv::norm(flow.forward, expected.forward, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(flow.backward, expected.backward, cv::NORM_INF), 0.0);
}

TEST(GrowFlow, BlankPicturesAreLeft) {
  const cv::Mat blank(kFlowHeight, kFlowWidth, CV_8UC1, cv::Scalar(120));
  FlowPair flow = FlowOfBackground();
  EXPECT_EQ(GrowFlow(blank, blank, {}, flow), 0);
}

TEST(GrowFlow, TakesTheSmallestPictures) {
  const cv::Mat small = TexturedImage(16, 16, 1);
  auto flow = Value(ComputeFlow(small, small, FlowQuality::kMedium));
  EXPECT_EQ(GrowFlow(small, small, {}, flow), 0);
}

}  // namespace
}  // namespace egosieve::vision
