// Pictures that a labeller cannot learn from, or hardly.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "tests/testing/status.h"
#include "tests/vision/labelling/feature_evaluation.h"
#include "tests/vision/labelling/same_labels.h"
#include "tests/vision/labelling/textured_scene.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {
namespace {

struct HardPair {
  const char* name;
  std::function<cv::Mat(int)> image;  // of frame 0 and 1
  std::vector<LabelOutcome> allowed;
};

cv::Mat Constant(int value) { return cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(value)); }

std::vector<HardPair> StressCases() {
  const LabelOutcome labelled = LabelOutcome::kLabelled, duplicate = LabelOutcome::kDuplicateFrame,
                     features = LabelOutcome::kTooFewFeatures,
                     matches = LabelOutcome::kTooFewMatches,
                     untrusted = LabelOutcome::kUntrustedMotion;
  return {
      {"black", [](int) { return Constant(0); }, {duplicate}},
      {"white, then nearly", [](int t) { return Constant(255 - t); }, {features}},
      {"lens cap",
       [](int t) { return t == 0 ? WallFrame(0).image : Constant(3); },
       {features, matches, untrusted}},
      {"identical", [](int) { return WallFrame(0).image; }, {duplicate}},
      {"noise",
       [](int t) {
         cv::Mat image(kHeight, kWidth, CV_8UC3);
         std::mt19937_64 engine(90 + t);
         for (size_t i = 0; i < image.total() * 3; ++i) {
           image.data[i] = static_cast<uint8_t>(engine());
         }
         return image;
       },
       {matches, untrusted}},
      {"cut", [](int t) { return Texture(kWidth, kHeight, 40 + t); }, {matches, untrusted}},
      {"quarter turn",
       [](int t) {
         cv::Mat image = Texture(kHeight, kHeight, 50), turned;
         if (t == 0) return image;
         cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
         return turned;
       },
       {labelled, matches, untrusted}},
      {"one row of texture",
       [](int t) {
         cv::Mat image = Constant(90);
         Texture(kWidth, 20, 60)(cv::Rect(t, 0, kWidth - 2, 4))
             .copyTo(image(cv::Rect(0, 80, kWidth - 2, 4)));
         return image;
       },
       {labelled, features, matches, untrusted}},
      {"a few dots",
       [](int t) {
         cv::Mat image = Constant(30);
         for (int k = 0; k < 5; ++k)
           cv::circle(image, {30 + 40 * k + t, 40 + 17 * k}, 4, {200, 220, 250}, -1);
         return image;
       },
       {labelled, features, matches, untrusted}},
      {"over-exposed",
       [](int t) { return cv::Mat(WallFrame(t).image * 4 + cv::Scalar::all(180)); },
       {labelled, features, matches, untrusted}},
  };
}

TEST(Stress, GivesADefinedOutcomeAndTheDriveGoesOn) {
  for (const FrameLabellerOptions& options : EveryKindOfOptions()) {
    for (const HardPair& stress : StressCases()) {
      SCOPED_TRACE(::testing::Message() << stress.name << (options.is_paper ? ", paper" : ""));
      auto labeller = MakeLabeller(options);
      ASSERT_TRUE(labeller->Process(FrameOf(0, stress.image(0))).ok());
      const auto labelled = Value(labeller->Process(FrameOf(1, stress.image(1))));
      ExpectWellFormed(labelled);
      if (!options.is_paper || labelled.outcome != LabelOutcome::kTooFewFeatures) {
        EXPECT_THAT(stress.allowed, ::testing::Contains(labelled.outcome))
            << Name(labelled.outcome) << ": " << labelled.reason;
      }
    }
  }
}

TEST(Stress, FramesOfAnotherSizeStartAnew) {
  auto labeller = MakeLabeller({});
  ASSERT_TRUE(labeller->Process(WallFrame(0)).ok());
  const auto changed = Value(labeller->Process(FrameOf(1, Texture(100, 90, 1))));
  EXPECT_EQ(changed.outcome, LabelOutcome::kSizeChanged);
  ExpectWellFormed(changed);
  const auto back = labeller->Process(WallFrame(2));
  EXPECT_EQ(back->outcome, LabelOutcome::kSizeChanged);
  EXPECT_EQ(labeller->Process(WallFrame(3))->outcome, LabelOutcome::kLabelled);
}

TEST(Stress, TinyFrames) {
  for (const FrameLabellerOptions& options : EveryKindOfOptions()) {
    for (const int side : {1, 2, 5, 15, 16, 17, 33}) {
      auto labeller = MakeLabeller(options);
      ASSERT_TRUE(labeller->Process(FrameOf(0, Texture(side, side, 1))).ok()) << side;
      const auto labelled = Value(labeller->Process(FrameOf(1, Texture(side, side, 2))));
      ExpectWellFormed(labelled);
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
