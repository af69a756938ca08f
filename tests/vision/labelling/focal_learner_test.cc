#include "vision/labelling/focal_learner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tests/vision/labelling/same_labels.h"
#include "tests/vision/labelling/street_drive.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/labelling/labeller_state.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

constexpr int kFrames = 20;

const Scenario& Turning() {
  static const Scenario& scenario = *new Scenario(EditedScenario("turning", 3, [](Scene&) {}));
  return scenario;
}

// Of the scenario while it turns, ten a second.
const std::vector<Frame>& TurningFrames() {
  static const std::vector<Frame>& frames = *new std::vector<Frame>([] {
    std::vector<Frame> turning;
    for (const DrivePicture& picture : PicturesOf(Turning(), 57, kFrames)) {
      turning.push_back(picture.frame);
      turning.back().index = static_cast<int64_t>(turning.size()) - 1;
      turning.back().time_seconds = 0.1 * static_cast<double>(turning.back().index);
    }
    return turning;
  }());
  return frames;
}

cv::Mat GreyOf(const Frame& frame) { return EqualizedGrey(frame.image, {}); }

FocalLearner Learner(const cv::Mat1b& ignored = {}) { return {ignored, {}}; }

bool Add(FocalLearner& learner, const Frame& frame) { return learner.Add(frame, GreyOf(frame)); }

TEST(FocalLearner, ATurnTellsTheFocalLength) {
  FocalLearner learner = Learner();
  std::vector<int64_t> changes;
  for (const Frame& frame : TurningFrames()) {
    if (Add(learner, frame)) changes.push_back(frame.index);
  }
  ASSERT_EQ(changes.size(), 2u);  // after the first and the second window
  EXPECT_GE(changes[0], 6);       // 0.6 s
  EXPECT_NEAR(std::log(learner.learnt().focal_ratio), std::log(FocalRatioOf(Turning())), 0.1);
  EXPECT_LT(learner.learnt().log_focal_deviation, 0.2);
}

// Directions of ten pictures a second, off by up to `spread` in each component.
FocalLearner AfterDirections(int count, double spread) {
  FocalLearner learner = Learner();
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d off(std::sin(1.7 * k), std::sin(2.3 * k), 0.0);
    learner.AddDirection((spread * off - Eigen::Vector3d::UnitZ()).normalized(), 0.1 * k);
  }
  return learner;
}

TEST(FocalLearner, AVehicleTravelsForward) {
  EXPECT_FALSE(AfterDirections(7, 0.02).learnt().travel.IsKnown());
  const TravelPrior travel = AfterDirections(8, 0.02).learnt().travel;
  EXPECT_TRUE(travel.IsOfVehicle());
  EXPECT_LT(travel.direction(2), -0.98);
}

TEST(FocalLearner, ACameraThatIsCarriedHasNoDirection) {
  EXPECT_FALSE(AfterDirections(40, 0.2).learnt().travel.IsKnown());
}

// A vehicle that creeps about before it drives.
TEST(FocalLearner, DirectionsOfAMinuteCount) {
  FocalLearner learner = AfterDirections(8, 0.3);
  ASSERT_FALSE(learner.learnt().travel.IsKnown());
  int changes = 0;
  for (int k = 8; k < 1000; ++k) {
    changes += learner.AddDirection(-Eigen::Vector3d::UnitZ(), 0.1 * k) ? 1 : 0;
  }
  EXPECT_TRUE(learner.learnt().travel.IsOfVehicle());
  EXPECT_EQ(changes, 3) << "after 16, 32 and 64";
}

TEST(FocalLearner, ACameraThatStandsTellsNothing) {
  FocalLearner learner = Learner();
  for (int64_t k = 0; k < 60; ++k) {
    Frame frame = TurningFrames()[0];
    frame.index = k;
    frame.time_seconds = 0.1 * static_cast<double>(k);
    EXPECT_FALSE(Add(learner, frame));
  }
  EXPECT_EQ(learner.learnt().focal_ratio, 0.0);
  EXPECT_TRUE(learner.state().windows.empty());
  // 21 pictures are a window, and as many pass before the next one.
  EXPECT_EQ(learner.state().next_start, 42);
  EXPECT_EQ(learner.state().under_way.pictures, 18);
}

TEST(FocalLearner, AnotherSceneEndsTheWindow) {
  FocalLearner learner = Learner();
  for (int k = 0; k < 4; ++k) Add(learner, TurningFrames()[k]);
  EXPECT_EQ(learner.state().under_way.pictures, 4);
  learner.EndScene();
  Add(learner, TurningFrames()[4]);
  EXPECT_EQ(learner.state().under_way.pictures, 1);
}

TEST(FocalLearner, PicturesOfAnotherSizeBeginAnew) {
  FocalLearner learner = Learner();
  for (const Frame& frame : TurningFrames()) Add(learner, frame);
  const double ratio = learner.learnt().focal_ratio;
  Frame half = TurningFrames().back();
  half.image = half.image(cv::Rect(0, 0, 200, 120)).clone();
  ++half.index;
  Add(learner, half);
  EXPECT_EQ(learner.learnt().focal_ratio, ratio);
  EXPECT_TRUE(learner.state().windows.empty());
  EXPECT_EQ(learner.state().under_way.pictures, 1);
}

TEST(FocalLearner, LeavesIgnoredPlacesOut) {
  cv::Mat1b ignored = cv::Mat1b::zeros(TurningFrames()[0].image.size());
  ignored.colRange(0, 200) = 255;
  FocalLearner learner = Learner(ignored);
  for (const Frame& frame : TurningFrames()) Add(learner, frame);
  ASSERT_FALSE(learner.state().windows.empty());
  for (const KeptTracks& window : learner.state().windows) {
    ASSERT_FALSE(window.tracks.empty());
    for (const CornerTrack& track : window.tracks) EXPECT_GT(track[0].x, 199.0f);
  }
}

// Beyond its last window it needs nothing.
TEST(FocalLearner, EndsAfterEightWindows) {
  FocalLearner learner = Learner();
  const int count = static_cast<int>(TurningFrames().size());
  // To and fro, so that one scene goes on.
  for (int64_t k = 0; k < 2000 && !learner.state().has_ended; ++k) {
    const int at = static_cast<int>(k % (2 * count - 2));
    Frame frame = TurningFrames()[at < count ? at : 2 * count - 2 - at];
    frame.index = k;
    frame.time_seconds = 0.1 * static_cast<double>(k);
    Add(learner, frame);
  }
  EXPECT_TRUE(learner.state().has_ended);
  EXPECT_TRUE(learner.state().windows.empty());
  EXPECT_EQ(learner.state().under_way.pictures, 0);
}

std::unique_ptr<FrameLabeller> OnlineLabeller(int labelling_size = 0) {
  return *MakeFrameLabeller({.longest_side_pixels = labelling_size, .frame_gap = 0});
}

TEST(FocalLearner, TheLabellerUsesItFromThenOn) {
  const auto labeller = OnlineLabeller();
  bool is_known = false;
  for (const Frame& frame : TurningFrames()) {
    ASSERT_TRUE(labeller->Process(frame).ok());
    const bool is_learnt = labeller->learnt_camera().focal_ratio > 0.0;
    EXPECT_FALSE(is_learnt && frame.index < 6) << frame.index;  // 0.6 s
    EXPECT_TRUE(is_learnt || !is_known) << frame.index;
    is_known = is_learnt;
  }
  EXPECT_TRUE(is_known);
  // Not where it is given.
  const auto given = *MakeFrameLabeller({.focal_ratio = 1.0});
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(given->Process(TurningFrames()[k]).ok());
  EXPECT_EQ(given->learnt_camera().focal_ratio, 0.0);
}

// Between windows, in the middle of one, and where the tracked picture is not the labelled one.
TEST(FocalLearner, TheLabellerResumesWithTheSameBytes) {
  for (const int size : {0, 200}) {
    const auto whole = OnlineLabeller(size);
    std::vector<LabelledFrame> labels;
    std::vector<std::string> states;
    for (const Frame& frame : TurningFrames()) {
      labels.push_back(*whole->Process(frame));
      states.push_back(whole->state());
    }
    for (const int last : {3, 6, 9}) {
      const auto resumed = OnlineLabeller(size);
      ASSERT_TRUE(resumed->Restore(states[last]).ok());
      const int first = std::max(0, last + 1 - resumed->options().HistoryFrames());
      for (int k = first; k <= last; ++k) ASSERT_TRUE(resumed->Prime(TurningFrames()[k]).ok());
      EXPECT_EQ(resumed->state(), states[last]);
      for (int k = last + 1; k < kFrames; ++k) {
        ExpectSame(*resumed->Process(TurningFrames()[k]), labels[k]);
        ASSERT_EQ(resumed->state(), states[k]) << k;
      }
    }
  }
}

TEST(FocalLearner, WithoutItsPictureTheWindowIsDropped) {
  FocalLearner learner = Learner();
  for (int k = 0; k < 4; ++k) Add(learner, TurningFrames()[k]);
  FocalLearner resumed = Learner();
  resumed.Restore(learner.state());
  Add(resumed, TurningFrames()[4]);
  EXPECT_EQ(resumed.state().under_way.pictures, 1);
}

// No corner is in a picture of one colour.
TEST(FocalLearner, AWindowWhoseCornersAreLostBeginsAgain) {
  FocalLearner learner = Learner();
  Add(learner, TurningFrames()[0]);
  Frame blank = TurningFrames()[1];
  blank.image = cv::Mat(blank.image.size(), CV_8UC3, cv::Scalar::all(90));
  Add(learner, blank);
  EXPECT_EQ(learner.state().under_way.pictures, 0);
  Add(learner, TurningFrames()[2]);
  EXPECT_EQ(learner.state().under_way.pictures, 1);
}

TEST(FocalLearner, ADamagedStateIsRefused) {
  const auto labeller = OnlineLabeller();
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(labeller->Process(TurningFrames()[k]).ok());
  const LabellerState sound = *FromBytes(labeller->state());
  const auto is_refused = [&](const std::function<void(FocalLearnerState&)>& damage) {
    LabellerState state = sound;
    damage(*state.focal);
    return !FromBytes(ToBytes(state)).ok();
  };
  const KeptTracks whole{3, std::vector<CornerTrack>(20, CornerTrack(3))},
      short_ones{3, std::vector<CornerTrack>(20, CornerTrack(1))},
      long_ones{7, std::vector<CornerTrack>(20, CornerTrack(7))};
  EXPECT_FALSE(is_refused([&](FocalLearnerState& focal) { focal.windows = {whole}; }));
  EXPECT_TRUE(is_refused([](FocalLearnerState& focal) { focal.directions = {{0.0, 0.0, 2.0}}; }));
  EXPECT_TRUE(is_refused([&](FocalLearnerState& focal) { focal.windows = {short_ones}; }));
  EXPECT_TRUE(is_refused([&](FocalLearnerState& focal) { focal.windows = {long_ones}; }));
  EXPECT_TRUE(is_refused([&](FocalLearnerState& focal) { focal.windows.assign(8, whole); }));
  EXPECT_TRUE(is_refused([](FocalLearnerState& focal) { focal.pictures = -1; }));
  EXPECT_TRUE(is_refused([](FocalLearnerState& focal) { focal.window_start = INT64_MAX; }));
  EXPECT_TRUE(is_refused([](FocalLearnerState& focal) { focal.learnt.log_focal_deviation = -1; }));
  EXPECT_TRUE(is_refused(
      [](FocalLearnerState& focal) { focal.under_way.tracks.at(0).at(0).x = std::nanf(""); }));
}

TEST(FocalLearner, AStateOfAnotherKindIsRefused) {
  const auto online = OnlineLabeller();
  const auto given = *MakeFrameLabeller({.focal_ratio = 1.0});
  EXPECT_FALSE(given->Restore(online->state()).ok());
  EXPECT_FALSE(online->Restore(given->state()).ok());
}

}  // namespace
}  // namespace egosieve::vision
