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

}  // namespace
}  // namespace egosieve::tools
