#include "tools/run_folder/doubtful_frames.h"

#include <gtest/gtest.h>

namespace egosieve::tools {
namespace {

FrameLine Line(const std::string& doubt, FrameLine::Outcome outcome, const std::string& reason) {
  FrameLine line;
  line.doubt = doubt;
  line.outcome = outcome;
  line.reason = reason;
  return line;
}

TEST(DoubtfulFrames, TheMostFrequentDoubtIsToldWithoutRegardToItsNumbers) {
  DoubtfulFrames frames;
  EXPECT_EQ(frames.Sentence(), "");
  frames.Add(Line("", FrameLine::Outcome::kLearnt, ""));
  // The same picture again is answered by the map before.
  frames.Add(Line("", FrameLine::Outcome::kAnswered, "the same picture as the frame before"));
  EXPECT_EQ(frames.Sentence(), "");
  frames.Add(Line("only 12 of 99 features have a match", FrameLine::Outcome::kAnswered, "x"));
  frames.Add(Line("43 % of the places", FrameLine::Outcome::kLearnt, ""));
  frames.Add(Line("7 % of the places", FrameLine::Outcome::kLearnt, ""));
  frames.Add(Line("", FrameLine::Outcome::kFailed, "damaged"));
  EXPECT_EQ(frames.count(), 4);
  EXPECT_EQ(frames.Sentence(), "4 of 6 frames are unreliable, most often: 43 % of the places");
}

// Which the labels' own doubt precedes; without a map there is nothing to expect.
TEST(DoubtfulFrames, AMapThatExpectsALittleOverlapIsDoubtful) {
  FrameLine line = Line("", FrameLine::Outcome::kLearnt, "");
  EXPECT_EQ(DoubtOf(line), "");
  line.expected_overlap = 0.4;
  EXPECT_EQ(DoubtOf(line), "");
  line.expected_overlap = 0.37;
  EXPECT_EQ(DoubtOf(line),
            "the map's probabilities expect an IoU of 0.37 between its mask and what moves");
  line.doubt = "few places";
  EXPECT_EQ(DoubtOf(line), "few places");
}

// A model that learnt from few of the frames is no success; what tells nothing new does not count.
TEST(DoubtfulFrames, TooFewFramesToLearnFromAreTold) {
  const auto learnt = Line("", FrameLine::Outcome::kLearnt, "");
  const auto lacks = [](int count) {
    const std::string reason = "only " + std::to_string(count) + " features";
    return Line(reason, FrameLine::Outcome::kAnswered, reason);
  };
  DoubtfulFrames half;
  EXPECT_EQ(half.TooFewLearnt(), "");
  for (int i = 0; i < 3; ++i) half.Add(learnt);
  for (int i = 0; i < 3; ++i) half.Add(lacks(i));
  for (int i = 0; i < 9; ++i) half.Add(Line("", FrameLine::Outcome::kAnswered, "the same again"));
  for (int i = 0; i < 9; ++i) half.Add(Line("", FrameLine::Outcome::kFailed, "damaged"));
  EXPECT_EQ(half.TooFewLearnt(), "");
  half.Add(lacks(7));
  EXPECT_EQ(half.TooFewLearnt(),
            "only 3 of 7 frames were learnt from, the others most often not because: only 0 "
            "features");

  // The pair of the first learnt frame lies two apart: two frames before it have none.
  DoubtfulFrames clip;
  for (int i = 0; i < 2; ++i) clip.Add(lacks(i));
  FrameLine first = learnt;
  first.frame_gap = 2;
  clip.Add(first);
  EXPECT_EQ(clip.TooFewLearnt(), "");
  for (int i = 0; i < 2; ++i) clip.Add(lacks(i));
  EXPECT_NE(clip.TooFewLearnt(), "");
}

}  // namespace
}  // namespace egosieve::tools
