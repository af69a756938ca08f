#include "vision/labelling/frame_labeller.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "vision/labelling/feature_evaluation.h"

namespace egosieve::vision {
namespace {

constexpr int kWidth = 240, kHeight = 160;

// Blurred noise: texture at several scales.
cv::Mat Texture(int width, int height, uint64_t seed) {
  std::mt19937_64 engine(seed);
  cv::Mat sum = cv::Mat::zeros(height, width, CV_32FC3);
  for (const int scale : {2, 5, 12}) {
    cv::Mat noise(height / scale + 2, width / scale + 2, CV_8UC3);
    for (int i = 0; i < noise.rows; ++i) {
      for (int j = 0; j < noise.cols; ++j) {
        for (int c = 0; c < 3; ++c) noise.at<cv::Vec3b>(i, j)[c] = static_cast<uint8_t>(engine());
      }
    }
    cv::Mat large;
    cv::resize(noise, large, cv::Size(width, height), 0, 0, cv::INTER_CUBIC);
    cv::Mat part;
    large.convertTo(part, CV_32FC3, 1.0 / 3);
    sum += part;
  }
  cv::Mat image;
  sum.convertTo(image, CV_8UC3);
  return image;
}

// A wide textured wall seen by a camera that turns 3 pixels a frame, and a square that moves
// against it.
Frame Scene(int64_t index, bool with_mover = true) {
  static const cv::Mat wall = Texture(3 * kWidth, kHeight, 5), square = Texture(60, 60, 6);
  Frame frame;
  frame.index = index;
  frame.time_seconds = 0.1 * static_cast<double>(index);
  frame.image = wall(cv::Rect(3 * static_cast<int>(index), 0, kWidth, kHeight)).clone();
  if (with_mover) {
    square.copyTo(frame.image(cv::Rect(30 + 4 * static_cast<int>(index), 50, 60, 60)));
  }
  return frame;
}

cv::Mat Mask(int64_t index) {
  cv::Mat mask = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  mask(cv::Rect(30 + 4 * static_cast<int>(index), 50, 60, 60)).setTo(255);
  return mask;
}

Frame FrameOf(int64_t index, const cv::Mat& image) {
  Frame frame;
  frame.index = index;
  frame.image = image;
  return frame;
}

std::vector<FrameLabellerOptions> EveryKindOfOptions() {
  std::vector<FrameLabellerOptions> all;
  for (const FeatureSource features : {FeatureSource::kSiftCorners, FeatureSource::kFlow,
                                       FeatureSource::kBoth, FeatureSource::kAuto}) {
    for (const LabelRule rule :
         {LabelRule::kScaledDistance, LabelRule::kScaledMedian, LabelRule::kMixture}) {
      for (const MotionModelChoice model :
           {MotionModelChoice::kAuto, MotionModelChoice::kFundamental}) {
        if (model == MotionModelChoice::kFundamental && rule != LabelRule::kScaledMedian) continue;
        FrameLabellerOptions options;
        options.features = features;
        options.label_rule = rule;
        options.motion_model = model;
        all.push_back(options);
      }
    }
  }
  all.push_back(FrameLabellerOptions::Paper());
  return all;
}

std::unique_ptr<FrameLabeller> MakeLabeller(const FrameLabellerOptions& options) {
  auto labeller = FrameLabeller::Create(options);
  EXPECT_TRUE(labeller.ok()) << labeller.status();
  return *std::move(labeller);
}

void ExpectWellFormed(const LabelledFrame& frame) {
  ASSERT_EQ(frame.positions.size(), 2 * frame.probability.size());
  ASSERT_EQ(frame.other_positions.size(), frame.positions.size());
  ASSERT_EQ(frame.residual_pixels.size(), frame.probability.size());
  for (int64_t i = 0; i < frame.size(); ++i) {
    EXPECT_TRUE(frame.probability[i] >= 0 && frame.probability[i] <= 1);
    EXPECT_TRUE(frame.positions[2 * i] >= 0 &&
                frame.positions[2 * i] <= frame.labelled.image.cols - 1);
    EXPECT_TRUE(frame.positions[2 * i + 1] >= 0 &&
                frame.positions[2 * i + 1] <= frame.labelled.image.rows - 1);
    EXPECT_TRUE(frame.residual_pixels[i] >= 0);
  }
  if (frame.outcome == LabelOutcome::kLabelled) {
    EXPECT_TRUE(frame.motion_trusted);
    EXPECT_TRUE(frame.reason.empty());
  } else {
    EXPECT_EQ(frame.size(), 0);
    EXPECT_FALSE(frame.reason.empty());
  }
}

void ExpectSame(const LabelledFrame& a, const LabelledFrame& b) {
  EXPECT_EQ(a.outcome, b.outcome);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.first_index, b.first_index);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.other_positions, b.other_positions);
  EXPECT_EQ(a.probability, b.probability);
  EXPECT_EQ(a.residual_pixels, b.residual_pixels);
  EXPECT_EQ(a.motion_model, b.motion_model);
  EXPECT_EQ(a.motion_matrix, b.motion_matrix);
  EXPECT_EQ(a.noise_pixels, b.noise_pixels);
}

TEST(FrameLabeller, MoverStandsOutWithEverySourceAndRule) {
  for (const FrameLabellerOptions& options : EveryKindOfOptions()) {
    if (options.motion_model == MotionModelChoice::kFundamental) continue;  // needs parallax
    SCOPED_TRACE(::testing::Message() << "features " << static_cast<int>(options.features)
                                      << " rule " << static_cast<int>(options.label_rule));
    auto labeller = MakeLabeller(options);
    ASSERT_TRUE(labeller->Process(Scene(0)).ok());
    const auto labelled = labeller->Process(Scene(1));
    ASSERT_TRUE(labelled.ok()) << labelled.status();
    ExpectWellFormed(*labelled);
    ASSERT_EQ(labelled->outcome, LabelOutcome::kLabelled) << labelled->reason;
    EXPECT_EQ(labelled->motion_model, MotionModelKind::kHomography);
    EXPECT_EQ(labelled->first_index, 0);
    EXPECT_EQ(labelled->labelled.index, 1);
    if (options.label_rule == LabelRule::kScaledDistance) continue;  // discards the mover
    const FeatureScore score = ScoreAgainstMask(*labelled, Mask(labelled->labelled.index));
    EXPECT_GT(score.residual_auc.value_or(0), 0.95);
    EXPECT_GT(score.label_auc.value_or(0), 0.95);
  }
}

TEST(FrameLabeller, PaperLabelsTheFirstFrameAndDiscardsBeyondItsDistance) {
  const FrameLabellerOptions options = FrameLabellerOptions::Paper();
  auto labeller = MakeLabeller(options);
  ASSERT_TRUE(labeller->Process(Scene(0)).ok());
  const auto labelled = labeller->Process(Scene(1));
  ASSERT_TRUE(labelled.ok());
  ASSERT_EQ(labelled->outcome, LabelOutcome::kLabelled) << labelled->reason;
  EXPECT_EQ(labelled->labelled.index, 0);
  EXPECT_EQ(labelled->frame_index, 1);
  EXPECT_EQ(labelled->motion_model, MotionModelKind::kFundamental);
  EXPECT_EQ(labelled->match_count, labelled->size() + labelled->discarded_count);
  for (int64_t i = 0; i < labelled->size(); ++i) {
    EXPECT_DOUBLE_EQ(labelled->probability[i], labelled->residual_pixels[i] / 3.0);
  }
}

TEST(FrameLabeller, SameBytesForOneTwoAndFourThreads) {
  for (FrameLabellerOptions options : EveryKindOfOptions()) {
    std::vector<LabelledFrame> reference;
    for (const int threads : {1, 2, 4}) {
      options.threads = threads;
      auto labeller = MakeLabeller(options);
      for (int64_t t = 0; t < 3; ++t) {
        const auto labelled = labeller->Process(Scene(t));
        ASSERT_TRUE(labelled.ok());
        if (threads == 1) {
          reference.push_back(*labelled);
        } else {
          ExpectSame(*labelled, reference[t]);
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
      reference.push_back(*whole->Process(Scene(t)));
      states.push_back(whole->state());
    }
    auto resumed = MakeLabeller(options);
    ASSERT_TRUE(resumed->Restore(states[4]).ok());
    ASSERT_TRUE(resumed->Prime(Scene(3)).ok());
    ASSERT_TRUE(resumed->Prime(Scene(4)).ok());
    for (int64_t t = 5; t < 7; ++t) ExpectSame(*resumed->Process(Scene(t)), reference[t]);
    EXPECT_EQ(resumed->state(), states[6]);
  }
}

TEST(FrameLabeller, ExtractingAheadChangesNothing) {
  FrameLabellerOptions options;
  auto in_turn = MakeLabeller(options), ahead = MakeLabeller(options);
  std::vector<std::shared_ptr<const ExtractedFrame>> extracted;
  for (int64_t t = 3; t >= 0; --t) extracted.insert(extracted.begin(), *ahead->Extract(Scene(t)));
  for (int64_t t = 0; t < 4; ++t) {
    ExpectSame(*ahead->Label(extracted[t]), *in_turn->Process(Scene(t)));
  }
}

TEST(FrameLabeller, FrameGapAndFirstFrames) {
  FrameLabellerOptions options;
  options.frame_gap = 3;
  auto labeller = MakeLabeller(options);
  for (int64_t t = 0; t < 6; ++t) {
    const auto labelled = labeller->Process(Scene(t));
    ASSERT_TRUE(labelled.ok());
    ExpectWellFormed(*labelled);
    if (t < 3) {
      EXPECT_EQ(labelled->outcome, LabelOutcome::kNoPair);
    } else {
      EXPECT_EQ(labelled->outcome, LabelOutcome::kLabelled) << labelled->reason;
      EXPECT_EQ(labelled->first_index, t - 3);
    }
  }
}

TEST(FrameLabeller, AutoGapResumesWithTheSameBytes) {
  FrameLabellerOptions options;
  options.frame_gap = 0;
  auto whole = MakeLabeller(options), resumed = MakeLabeller(options);
  std::vector<LabelledFrame> reference;
  std::vector<std::string> states;
  const auto frame = [](int64_t t) {
    return t == 3 ? FrameOf(3, Scene(2).image) : Scene(t);  // a picture that is repeated
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

TEST(FrameLabeller, ADarkFrameEndsTheTracksAndMissingFramesDoNot) {
  FrameLabellerOptions options;
  options.frame_gap = 2;
  auto labeller = MakeLabeller(options);
  for (const int64_t t : {0, 1, 2}) ASSERT_TRUE(labeller->Process(Scene(t)).ok());
  // 3 and 4 are missing: the step is longer, nothing else.
  const auto behind = labeller->Process(Scene(5));
  ASSERT_TRUE(behind.ok());
  ASSERT_EQ(behind->outcome, LabelOutcome::kLabelled) << behind->reason;
  EXPECT_EQ(behind->first_index, 1);
  EXPECT_GT(ScoreAgainstMask(*behind, Mask(5)).label_auc.value_or(0), 0.95);
  // A covered lens: no pair reaches across it.
  ASSERT_NE(
      labeller->Process(FrameOf(6, cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(3))))->outcome,
      LabelOutcome::kLabelled);
  for (int64_t t = 7; t < 11; ++t) {
    const auto labelled = labeller->Process(Scene(t));
    ASSERT_TRUE(labelled.ok());
    ExpectWellFormed(*labelled);
    EXPECT_EQ(labelled->outcome == LabelOutcome::kLabelled, t >= 9) << t << labelled->reason;
    if (t >= 9) {
      EXPECT_GE(labelled->first_index, 7);
    }
  }
}

TEST(FrameLabeller, ACameraThatTurnsKnowsOfNoDepth) {
  auto labeller = MakeLabeller({});
  for (int64_t t = 0; t < 5; ++t) {
    const auto labelled = labeller->Process(Scene(t));
    ASSERT_TRUE(labelled.ok());
    for (const EvidenceTerm term : labelled->decided_by) EXPECT_EQ(term, EvidenceTerm::kEpipolar);
  }
}

TEST(FrameLabeller, ErrorsLeaveTheStateAsItWas) {
  auto labeller = MakeLabeller({}), other = MakeLabeller({});
  for (auto* each : {&labeller, &other}) ASSERT_TRUE((*each)->Process(Scene(1)).ok());
  EXPECT_FALSE(labeller->Process(Scene(1)).ok()) << "the index does not grow";
  EXPECT_FALSE(labeller->Process(Scene(0)).ok());
  EXPECT_FALSE(labeller->Process(FrameOf(2, cv::Mat())).ok());
  EXPECT_FALSE(labeller->Process(FrameOf(2, cv::Mat(20, 20, CV_16UC3))).ok());
  EXPECT_FALSE(labeller->Label(nullptr).ok());
  const std::string state = labeller->state();
  EXPECT_FALSE(labeller->Restore("").ok());
  EXPECT_FALSE(labeller->Restore(state + " ").ok());
  EXPECT_FALSE(labeller->Restore(absl::string_view(state).substr(0, state.size() - 1)).ok());
  ExpectSame(*labeller->Process(Scene(2)), *other->Process(Scene(2)));
}

// Pairs of frames that nothing, or little, can be learnt from.
struct Stress {
  const char* name;
  std::function<cv::Mat(int)> image;  // of frame 0 and 1
  std::vector<LabelOutcome> allowed;
};

cv::Mat Constant(int value) { return cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(value)); }

std::vector<Stress> StressCases() {
  const LabelOutcome labelled = LabelOutcome::kLabelled, duplicate = LabelOutcome::kDuplicateFrame,
                     features = LabelOutcome::kTooFewFeatures,
                     matches = LabelOutcome::kTooFewMatches,
                     untrusted = LabelOutcome::kUntrustedMotion;
  return {
      {"black", [](int) { return Constant(0); }, {duplicate}},
      {"white, then nearly", [](int t) { return Constant(255 - t); }, {features}},
      {"lens cap",
       [](int t) { return t == 0 ? Scene(0).image : Constant(3); },
       {features, matches, untrusted}},
      {"identical", [](int) { return Scene(0).image; }, {duplicate}},
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
       [](int t) { return cv::Mat(Scene(t).image * 4 + cv::Scalar::all(180)); },
       {labelled, features, matches, untrusted}},
  };
}

TEST(FrameLabeller, StressGivesADefinedOutcomeAndTheDriveGoesOn) {
  for (const FrameLabellerOptions& options : EveryKindOfOptions()) {
    for (const Stress& stress : StressCases()) {
      SCOPED_TRACE(::testing::Message()
                   << stress.name << ", features " << static_cast<int>(options.features)
                   << ", rule " << static_cast<int>(options.label_rule));
      auto labeller = MakeLabeller(options);
      ASSERT_TRUE(labeller->Process(FrameOf(0, stress.image(0))).ok());
      const auto labelled = labeller->Process(FrameOf(1, stress.image(1)));
      ASSERT_TRUE(labelled.ok()) << labelled.status();
      ExpectWellFormed(*labelled);
      const bool is_flow_free = options.features == FeatureSource::kSiftCorners;
      if (!is_flow_free || labelled->outcome != LabelOutcome::kTooFewFeatures) {
        EXPECT_THAT(stress.allowed, ::testing::Contains(labelled->outcome))
            << Name(labelled->outcome) << ": " << labelled->reason;
      }
    }
  }
}

TEST(FrameLabeller, FramesOfAnotherSizeStartAnew) {
  auto labeller = MakeLabeller({});
  ASSERT_TRUE(labeller->Process(Scene(0)).ok());
  const auto changed = labeller->Process(FrameOf(1, Texture(100, 90, 1)));
  ASSERT_TRUE(changed.ok());
  EXPECT_EQ(changed->outcome, LabelOutcome::kSizeChanged);
  ExpectWellFormed(*changed);
  const auto back = labeller->Process(Scene(2));
  EXPECT_EQ(back->outcome, LabelOutcome::kSizeChanged);
  EXPECT_EQ(labeller->Process(Scene(3))->outcome, LabelOutcome::kLabelled);
}

TEST(FrameLabeller, TinyFrames) {
  for (const FrameLabellerOptions& options : EveryKindOfOptions()) {
    for (const int side : {1, 2, 5, 15, 16, 17, 33}) {
      auto labeller = MakeLabeller(options);
      ASSERT_TRUE(labeller->Process(FrameOf(0, Texture(side, side, 1))).ok()) << side;
      const auto labelled = labeller->Process(FrameOf(1, Texture(side, side, 2)));
      ASSERT_TRUE(labelled.ok()) << side << labelled.status();
      ExpectWellFormed(*labelled);
    }
  }
}

// A camera that stands still among movers: nothing moves but they.
TEST(FrameLabeller, StandingCameraIsFoundStatic) {
  const cv::Mat wall = Texture(kWidth, kHeight, 70), square = Texture(50, 50, 71);
  auto labeller = MakeLabeller({});
  for (int t = 0; t < 3; ++t) {
    cv::Mat image = wall.clone();
    square.copyTo(image(cv::Rect(40 + 5 * t, 60, 50, 50)));
    const auto labelled = labeller->Process(FrameOf(t, image));
    ASSERT_TRUE(labelled.ok());
    if (t == 0) continue;
    ASSERT_EQ(labelled->outcome, LabelOutcome::kLabelled) << labelled->reason;
    EXPECT_EQ(labelled->motion_model, MotionModelKind::kStatic);
    cv::Mat mask = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
    mask(cv::Rect(40 + 5 * t, 60, 50, 50)).setTo(255);
    EXPECT_GT(ScoreAgainstMask(*labelled, mask).label_auc.value_or(0), 0.95);
  }
}

TEST(FrameLabellerOptions, NonsenseIsRefusedByName) {
  const auto refused = [](auto change, const char* field) {
    FrameLabellerOptions options;
    change(options);
    const absl::Status status = FrameLabeller::Create(options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << field;
    EXPECT_NE(std::string(status.message()).find(field), std::string::npos) << status;
  };
  refused([](auto& o) { o.frame_gap = -1; }, "frame_gap");
  refused([](auto& o) { o.feature_count = -1; }, "feature_count");
  refused([](auto& o) { o.match_ratio = NAN; }, "match_ratio");
  refused([](auto& o) { o.flow_stride_pixels = 0; }, "flow_stride_pixels");
  refused([](auto& o) { o.paper_distance_pixels = 0; }, "paper_distance_pixels");
  refused([](auto& o) { o.median_multiple = INFINITY; }, "median_multiple");
  refused([](auto& o) { o.noise_floor_pixels = -1; }, "noise_floor_pixels");
  refused([](auto& o) { o.minimum_matches = 7; }, "minimum_matches");
  refused([](auto& o) { o.threads = 0; }, "threads");
}

}  // namespace
}  // namespace egosieve::vision
