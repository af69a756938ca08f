#include "vision/labelling/shots.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/testing/status.h"
#include "tests/vision/frame/fake_source.h"
#include "tests/vision/labelling/same_labels.h"
#include "tests/vision/labelling/textured_scene.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

using testing::ElementsAre;

// The view, `shift` pixels to the right, of a wide wall.
cv::Mat View(uint64_t seed, int shift) {
  return Texture(900, kHeight, seed)(cv::Rect(shift, 0, kWidth, kHeight)).clone();
}

std::vector<int64_t> ShotsOf(int64_t count, const std::function<cv::Mat(int64_t)>& picture,
                             int64_t begin = 0, int64_t end = -1,
                             const std::set<int64_t>& damaged = {}) {
  FakeSource source(count, damaged, [&](int64_t index) { return FrameOf(index, picture(index)); });
  EXPECT_TRUE(source.SeekTo(begin).ok());
  return Value(FindShots(source, begin, end));
}

// Of the wall 1 up to frame 9, of the wall 2 up to frame 19, then of the wall 3.
cv::Mat ThreeWalls(int64_t index) { return View(1 + index / 10, 3 * static_cast<int>(index % 10)); }

TEST(FindShots, EachCutBeginsOne) {
  EXPECT_THAT(ShotsOf(30, ThreeWalls), ElementsAre(0, 10, 20));
  EXPECT_THAT(ShotsOf(30, ThreeWalls, 5, 22), ElementsAre(5, 10));
  EXPECT_THAT(ShotsOf(30, ThreeWalls, 0, -1, {9, 10, 21}), ElementsAre(0, 11, 20));
}

TEST(FindShots, AFlashADamagedPictureOrAQuickTurnIsNone) {
  const auto turning = [](int64_t index) { return View(1, 3 * static_cast<int>(index)); };
  EXPECT_THAT(ShotsOf(30, [&](int64_t index) { return index == 12 ? View(7, 0) : turning(index); }),
              ElementsAre(0));
  EXPECT_THAT(ShotsOf(30,
                      [&](int64_t index) {
                        cv::Mat picture = turning(index);
                        if (index % 7 == 3) picture = cv::Mat(picture * 0.5 + cv::Scalar::all(120));
                        return picture;
                      }),
              ElementsAre(0));
  // From picture 10 to 13 it turns by more than flow follows.
  EXPECT_THAT(ShotsOf(30,
                      [](int64_t index) {
                        const int quick = static_cast<int>(std::clamp<int64_t>(index - 10, 0, 3));
                        return View(1, 2 * static_cast<int>(index) + 190 * quick);
                      }),
              ElementsAre(0));
}

TEST(FindShots, PicturesOfAnotherSizeAreNoShot) {
  EXPECT_THAT(ShotsOf(30,
                      [](int64_t index) {
                        const cv::Mat view = View(1, 2 * static_cast<int>(index));
                        return index < 15 ? view : cv::Mat(view(cv::Rect(0, 0, 200, 120)));
                      }),
              ElementsAre(0));
}

TEST(FindShots, BlackAtTheBeginningIsNoShot) {
  EXPECT_THAT(
      ShotsOf(30,
              [](int64_t index) {
                return cv::Mat(View(1, 2 * static_cast<int>(index)) * (index < 6 ? 0.0 : 1.0));
              }),
      ElementsAre(0));
}

TEST(FindShots, AFadeThroughBlackIsACut) {
  EXPECT_THAT(
      ShotsOf(30,
              [](int64_t index) {
                const double level = std::min(1.0, std::abs(static_cast<double>(index) - 15) / 5);
                return cv::Mat(View(index < 15 ? 1 : 2, 2 * static_cast<int>(index)) * level);
              }),
      ElementsAre(0, testing::AllOf(testing::Ge(15), testing::Le(18))));
}

// Both shots are labelled as if each were a drive by itself with its own lens, also after a state
// was restored in either.
TEST(ShotLabeller, LabelsEachShotAsADriveOfItsOwn) {
  constexpr int64_t kCut = 6, kEnd = 12;
  FrameLabellerOptions first, second;
  first.focal_ratio = 0.8;
  second.focal_ratio = 1.6;
  second.first_frame = kCut;
  FrameLabellerOptions both = first;
  both.later_shots = {second};
  const auto frame = [](int64_t index) {
    Frame wall = WallFrame(index);
    if (index >= kCut) cv::flip(wall.image, wall.image, 0);
    return wall;
  };
  std::vector<LabelledFrame> expected;
  for (const FrameLabellerOptions& options : {first, second}) {
    const auto alone = MakeLabeller(options);
    const int64_t begin = options.first_frame;
    for (int64_t t = begin; t < begin + kCut; ++t) {
      std::vector<std::shared_ptr<const ExtractedFrame>> ahead;
      if (t + 1 < begin + kCut) ahead.push_back(Value(alone->Extract(frame(t + 1))));
      expected.push_back(Value(alone->Label(Value(alone->Extract(frame(t))), ahead)));
    }
  }
  std::vector<std::string> states;
  const auto label = [&](FrameLabeller& labeller, int64_t t) {
    const auto now = Value(labeller.Extract(frame(t)));
    std::vector<std::shared_ptr<const ExtractedFrame>> ahead;
    if (t + 1 < kEnd) ahead.push_back(Value(labeller.Extract(frame(t + 1))));
    if (!ahead.empty()) {
      EXPECT_TRUE(labeller.Prepare(*now, *ahead[0]).ok());
    }
    ExpectSame(Value(labeller.Label(now, ahead)), expected[t]);
  };
  const auto whole = MakeLabeller(both);
  for (int64_t t = 0; t < kEnd; ++t) {
    SCOPED_TRACE(t);
    label(*whole, t);
    states.push_back(whole->state());
  }
  for (const int64_t stop : {kCut - 2, kCut - 1, kCut, kCut + 2}) {
    SCOPED_TRACE(stop);
    const auto resumed = MakeLabeller(both);
    ASSERT_TRUE(resumed->Restore(states[stop]).ok());
    EXPECT_EQ(resumed->state(), states[stop]);
    for (int64_t t = std::max<int64_t>(0, stop - both.HistoryFrames() + 1); t <= stop; ++t) {
      ASSERT_TRUE(resumed->Prime(frame(t)).ok());
    }
    for (int64_t t = stop + 1; t < kEnd; ++t) label(*resumed, t);
  }
  EXPECT_FALSE(whole->Restore("short").ok());
}

}  // namespace
}  // namespace egosieve::vision
