#include "vision/labelling/frame_labeller.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "kernels/base/parallel_for.h"
#include "tests/testing/status.h"
#include "tests/vision/labelling/feature_evaluation.h"
#include "tests/vision/labelling/same_labels.h"
#include "tests/vision/labelling/textured_scene.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

TEST(FrameLabeller, MoverStandsOut) {
  for (const FrameLabellerOptions& options : EveryKindOfOptions()) {
    if (options.is_paper) continue;  // needs parallax
    SCOPED_TRACE(options.focal_ratio);
    auto labeller = MakeLabeller(options);
    ASSERT_TRUE(labeller->Process(WallFrame(0)).ok());
    const auto labelled = Value(labeller->Process(WallFrame(1)));
    ExpectWellFormed(labelled);
    ASSERT_EQ(labelled.outcome, LabelOutcome::kLabelled) << labelled.reason;
    EXPECT_EQ(labelled.first_index, 0);
    EXPECT_EQ(labelled.labelled.index, 1);
    EXPECT_GT(AreaUnderMask(labelled, WallMask(labelled.labelled.index)), 0.95);
  }
}

// among_movers.h
TEST(FrameLabeller, WhatIsBlankWithinAMoverHasNoLabelAndWhatIsBlankInTheWallHas) {
  const auto blank = [](const cv::Point& corner) { return cv::Rect(corner, cv::Size(40, 40)); };
  for (const FrameLabellerOptions& options : EveryKindOfOptions()) {
    if (options.is_paper) continue;
    SCOPED_TRACE(options.focal_ratio);
    auto labeller = MakeLabeller(options);
    LabelledFrame labelled;
    cv::Rect of_square, of_wall;
    for (int t = 0; t < 2; ++t) {
      Frame frame = WallFrame(t);
      of_square = blank({40 + 4 * t, 60});
      of_wall = blank({160 - 3 * t, 60});
      for (const cv::Rect& part : {of_square, of_wall}) frame.image(part).setTo(128);
      labelled = Value(labeller->Process(frame));
    }
    ASSERT_EQ(labelled.outcome, LabelOutcome::kLabelled) << labelled.reason;
    const auto labels_deep_in = [&](const cv::Rect& part) {
      const cv::Rect core(part.tl() + cv::Point(10, 10), cv::Size(20, 20));
      int count = 0;
      for (int64_t i = 0; i < labelled.size(); ++i) {
        count += core.contains(
            cv::Point(cvFloor(labelled.positions[2 * i]), cvFloor(labelled.positions[2 * i + 1])));
      }
      return count;
    };
    EXPECT_EQ(labels_deep_in(of_square), 0);
    EXPECT_GT(labels_deep_in(of_wall), 10);
  }
}

TEST(FrameLabeller, PaperLabelsTheFirstFrameAndDiscardsBeyondItsDistance) {
  // Wall and square move along horizontal epipolar lines, two patches off them.
  constexpr int kSide = 32, kNear = 2, kFar = 5;  // pixels
  const auto patches = [](int index) {
    return std::vector{cv::Rect(160 - 3 * index, 20 + kNear * index, kSide, kSide),
                       cv::Rect(160 + index, 90 + kFar * index, kSide, kSide)};
  };
  auto labeller = MakeLabeller(FrameLabellerOptions::Paper());
  LabelledFrame labelled;
  for (int t = 0; t < 2; ++t) {
    Frame frame = WallFrame(t);
    for (int k = 0; k < 2; ++k) Texture(kSide, kSide, 7 + k).copyTo(frame.image(patches(t)[k]));
    labelled = Value(labeller->Process(std::move(frame)));
  }
  ASSERT_EQ(labelled.outcome, LabelOutcome::kLabelled) << labelled.reason;
  ExpectWellFormed(labelled);
  EXPECT_EQ(labelled.labelled.index, 0);
  EXPECT_EQ(labelled.frame_index, 1);
  EXPECT_EQ(labelled.motion_model, MotionModelKind::kFundamental);
  EXPECT_EQ(labelled.match_count, labelled.size() + labelled.discarded_count);
  EXPECT_GT(labelled.discarded_count, 3);
  std::vector<double> of_near;
  for (int64_t i = 0; i < labelled.size(); ++i) {
    const cv::Point at(cvRound(labelled.positions[2 * i]), cvRound(labelled.positions[2 * i + 1]));
    if (patches(0)[0].contains(at)) of_near.push_back(labelled.probability[i]);
    EXPECT_FALSE(patches(0)[1].contains(at)) << at;
  }
  ASSERT_GT(of_near.size(), 5u);
  std::ranges::sort(of_near);
  // Places are exact to some hundredths of a pixel.
  EXPECT_NEAR(of_near[of_near.size() / 2], kNear / 3.0, 0.05 / 3.0);
}

TEST(FrameLabeller, SameBytesForOneTwoAndFourThreads) {
  for (const FrameLabellerOptions& options : EveryKindOfOptions()) {
    std::vector<LabelledFrame> reference;
    for (const int threads : {1, 2, 4}) {
      kernels::SetMaximumThreads(threads);
      auto labeller = MakeLabeller(options);
      for (int64_t t = 0; t < 3; ++t) {
        const auto labelled = Value(labeller->Process(WallFrame(t)));
        if (threads == 1) {
          reference.push_back(labelled);
        } else {
          ExpectSame(labelled, reference[t]);
        }
      }
    }
  }
}

TEST(FrameLabeller, ResumesWithTheSameBytes) {
  for (FrameLabellerOptions options : EveryKindOfOptions()) {
    options.frame_gap = 2;
    auto whole = MakeLabeller(options);
    std::vector<LabelledFrame> reference;
    std::vector<std::string> states;
    for (int64_t t = 0; t < 7; ++t) {
      reference.push_back(*whole->Process(WallFrame(t)));
      states.push_back(whole->state());
    }
    auto resumed = MakeLabeller(options);
    ASSERT_TRUE(resumed->Restore(states[4]).ok());
    ASSERT_TRUE(resumed->Prime(WallFrame(3)).ok());
    ASSERT_TRUE(resumed->Prime(WallFrame(4)).ok());
    for (int64_t t = 5; t < 7; ++t) ExpectSame(*resumed->Process(WallFrame(t)), reference[t]);
    EXPECT_EQ(resumed->state(), states[6]);
  }
}

TEST(FrameLabeller, ExtractingAheadChangesNothing) {
  FrameLabellerOptions options;
  auto in_turn = MakeLabeller(options), ahead = MakeLabeller(options);
  std::vector<std::shared_ptr<const ExtractedFrame>> extracted;
  for (int64_t t = 3; t >= 0; --t)
    extracted.insert(extracted.begin(), *ahead->Extract(WallFrame(t)));
  for (int64_t t = 0; t < 4; ++t) {
    ExpectSame(*ahead->Label(extracted[t]), *in_turn->Process(WallFrame(t)));
  }
}

TEST(FrameLabeller, FrameGapAndFirstFrames) {
  auto labeller = MakeLabeller({.frame_gap = 3});
  for (int64_t t = 0; t < 6; ++t) {
    const auto labelled = Value(labeller->Process(WallFrame(t)));
    ExpectWellFormed(labelled);
    if (t < 3) {
      EXPECT_EQ(labelled.outcome, LabelOutcome::kNoPair);
    } else {
      EXPECT_EQ(labelled.outcome, LabelOutcome::kLabelled) << labelled.reason;
      EXPECT_EQ(labelled.first_index, t - 3);
    }
  }
}

TEST(FrameLabeller, AutoGapResumesWithTheSameBytes) {
  FrameLabellerOptions options{.frame_gap = 0};
  auto whole = MakeLabeller(options), resumed = MakeLabeller(options);
  std::vector<LabelledFrame> reference;
  std::vector<std::string> states;
  const auto frame = [](int64_t t) {
    return t == 3 ? FrameOf(3, WallFrame(2).image) : WallFrame(t);  // a picture that is repeated
  };
  for (int64_t t = 0; t < 7; ++t) {
    reference.push_back(*whole->Process(frame(t)));
    states.push_back(whole->state());
    if (t == 0) continue;
    EXPECT_EQ(reference[t].outcome,
              t == 3 ? LabelOutcome::kDuplicateFrame : LabelOutcome::kLabelled);
  }
  for (const int64_t last : {3, 4}) {
    ASSERT_TRUE(resumed->Restore(states[last]).ok());
    for (int64_t t = std::max<int64_t>(0, last + 1 - options.HistoryFrames()); t <= last; ++t) {
      ASSERT_TRUE(resumed->Prime(frame(t)).ok());
    }
    for (int64_t t = last + 1; t < 7; ++t) ExpectSame(*resumed->Process(frame(t)), reference[t]);
    EXPECT_EQ(resumed->state(), states[6]);
  }
}

// A video whose container repeats pictures: pairs of several pictures reach as far as without.
TEST(FrameLabeller, RepeatedPicturesAreNoPictures) {
  for (FrameLabellerOptions options : {FrameLabellerOptions(), FrameLabellerOptions::Paper()}) {
    SCOPED_TRACE(options.is_paper);
    options.frame_gap = 3;
    auto plain = MakeLabeller(options), doubled = MakeLabeller(options);
    int64_t index = 0;
    for (int64_t t = 0; t < 7; ++t) {
      const LabelledFrame expected = *plain->Process(WallFrame(t));
      const LabelledFrame actual = *doubled->Process(FrameOf(index++, WallFrame(t).image));
      EXPECT_EQ(actual.outcome, expected.outcome);
      EXPECT_EQ(actual.match_count, expected.match_count);
      // Random numbers depend on the frames' indices, and with them the paper's fundamental matrix.
      if (!options.is_paper) {
        EXPECT_THAT(actual.probability,
                    testing::Pointwise(testing::DoubleNear(0.01), expected.probability));
      }
      EXPECT_EQ(doubled->Process(FrameOf(index++, WallFrame(t).image))->outcome,
                LabelOutcome::kDuplicateFrame);
    }
  }
}

TEST(FrameLabeller, ADarkFrameEndsTheTracksAndMissingFramesDoNot) {
  auto labeller = MakeLabeller({.frame_gap = 2});
  for (const int64_t t : {0, 1, 2}) ASSERT_TRUE(labeller->Process(WallFrame(t)).ok());
  // 3 and 4 are missing: the step is longer, nothing else.
  const auto behind = Value(labeller->Process(WallFrame(5)));
  ASSERT_EQ(behind.outcome, LabelOutcome::kLabelled) << behind.reason;
  EXPECT_EQ(behind.first_index, 1);
  EXPECT_GT(AreaUnderMask(behind, WallMask(5)), 0.95);
  // A covered lens: no pair reaches across it.
  ASSERT_NE(
      labeller->Process(FrameOf(6, cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(3))))->outcome,
      LabelOutcome::kLabelled);
  for (int64_t t = 7; t < 11; ++t) {
    const auto labelled = Value(labeller->Process(WallFrame(t)));
    ExpectWellFormed(labelled);
    EXPECT_EQ(labelled.outcome == LabelOutcome::kLabelled, t >= 9) << t << labelled.reason;
    if (t >= 9) {
      EXPECT_GE(labelled.first_index, 7);
    }
  }
}

TEST(FrameLabeller, ACameraThatTurnsKnowsOfNoDepth) {
  auto labeller = MakeLabeller({});
  for (int64_t t = 0; t < 5; ++t) {
    const auto labelled = Value(labeller->Process(WallFrame(t)));
    for (const EvidenceTerm term : labelled.decided_by) EXPECT_EQ(term, EvidenceTerm::kEpipolar);
  }
}

TEST(FrameLabeller, ErrorsLeaveTheStateAsItWas) {
  auto labeller = MakeLabeller({}), other = MakeLabeller({});
  for (auto* each : {&labeller, &other}) ASSERT_TRUE((*each)->Process(WallFrame(1)).ok());
  EXPECT_FALSE(labeller->Process(WallFrame(1)).ok()) << "the index does not grow";
  EXPECT_FALSE(labeller->Process(WallFrame(0)).ok());
  EXPECT_FALSE(labeller->Process(FrameOf(2, cv::Mat())).ok());
  EXPECT_FALSE(labeller->Process(FrameOf(2, cv::Mat(20, 20, CV_16UC3))).ok());
  EXPECT_FALSE(labeller->Label(nullptr).ok());
  const std::string state = labeller->state();
  EXPECT_FALSE(labeller->Restore("").ok());
  EXPECT_FALSE(labeller->Restore(state + " ").ok());
  EXPECT_FALSE(labeller->Restore(absl::string_view(state).substr(0, state.size() - 1)).ok());
  ExpectSame(*labeller->Process(WallFrame(2)), *other->Process(WallFrame(2)));
}

TEST(FrameLabellerOptions, NonsenseIsRefusedByName) {
  const auto refused = [](auto change, const char* field) {
    FrameLabellerOptions options;
    change(options);
    const absl::Status status = MakeFrameLabeller(options).status();
    EXPECT_THAT(status, IsInvalid()) << field;
    EXPECT_THAT(status.message(), testing::HasSubstr(field));
  };
  refused([](auto& o) { o.frame_gap = -1; }, "frame_gap");
  refused([](auto& o) { o.is_paper = (o.frame_gap = 0) == 0; }, "frame_gap");
}

}  // namespace
}  // namespace egosieve::vision
