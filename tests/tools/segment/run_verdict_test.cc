#include "tools/segment/run_verdict.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace egosieve::tools {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Outcome = FrameLine::Outcome;

// `learnt` frames, and then others that are answered for the reason, with doubt or without.
RunVerdict Judge(int learnt, int answered, const std::string& reason, const std::string& doubt) {
  DriveWriter::Counts counts((RunDescription()));
  for (int i = 0; i < learnt + answered; ++i) {
    FrameLine line;
    line.index = i;
    line.outcome = i < learnt ? Outcome::kLearnt : Outcome::kAnswered;
    if (i >= learnt) {
      line.reason = reason;
      line.doubt = doubt;
    }
    counts.Add(line);
  }
  return JudgeRun(counts, "");
}

TEST(RunVerdict, ARunThatLearntFromNothingOrFewFramesIsNoSuccess) {
  const RunVerdict nothing = Judge(0, 9, "only 3 features", "only 3 features");
  EXPECT_EQ(nothing.code, ExitCode::kFramesFailed);
  EXPECT_THAT(nothing.warnings, ElementsAre(HasSubstr("nothing was learnt")));

  const RunVerdict few = Judge(4, 5, "only 3 features", "only 3 features");
  EXPECT_EQ(few.code, ExitCode::kFramesFailed);
  EXPECT_THAT(few.warnings, ElementsAre(HasSubstr("only 4 of 9 frames were learnt from")));

  const RunVerdict half = Judge(5, 5, "only 3 features", "only 3 features");
  EXPECT_EQ(half.code, ExitCode::kDone);
  EXPECT_THAT(half.warnings, IsEmpty());
}

// The same picture again, as where a camera's pictures were doubled.
TEST(RunVerdict, RepeatedPicturesDoNotCount) {
  EXPECT_EQ(Judge(4, 20, "the same picture as the frame before", "").code, ExitCode::kDone);
  EXPECT_EQ(Judge(0, 20, "the same picture as the frame before", "").code, ExitCode::kFramesFailed);
}

TEST(RunVerdict, AnInputThatEndsTooEarlyIsNoSuccess) {
  const RunVerdict verdict = JudgeRun(DriveWriter::Counts((RunDescription())), "a.mp4: cut short");
  EXPECT_EQ(verdict.code, ExitCode::kFramesFailed);
  EXPECT_THAT(verdict.warnings, ElementsAre("a.mp4: cut short"));
}

}  // namespace
}  // namespace egosieve::tools
