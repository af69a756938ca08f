#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/baselines.h"
#include "tools/run_folder/doubtful_frames.h"
#include "tools/run_folder/line_log.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

Baselines Of(const std::string& front_end, int near, int far) {
  RunDescription description;
  description.flags["front_end"] = front_end;
  Baselines baselines(description);
  FrameLine line;
  baselines.Add(line);  // the first frame has no pair
  line.features = 10000;
  for (int i = 0; i < near + far; ++i) {
    line.matches = i < near ? 7000 : 6999;
    baselines.Add(line);
  }
  return baselines;
}

TEST(Baselines, TellARunOfWhichATenthLiesFarApart) {
  EXPECT_EQ(Of("default", 9, 1).far_apart(), 1);
  EXPECT_THAT(Of("default", 9, 1).Describe(),
              HasSubstr("1 of 10 pairs of pictures lie too far apart"));
  EXPECT_THAT(Of("default", 0, 4).Describe(), HasSubstr("--from_video"));
}

TEST(Baselines, SayNothingOfCutsNorOfMatchedFeatures) {
  EXPECT_EQ(Of("default", 10, 1).Describe(), "");
  EXPECT_EQ(Of("default", 10, 0).Describe(), "");
  EXPECT_EQ(Of("default", 0, 0).Describe(), "");
  EXPECT_EQ(Of("paper", 0, 5).Describe(), "");
}

std::string OfNames(const std::vector<std::string>& names, int64_t index_step = 1) {
  Baselines baselines{RunDescription()};
  FrameLine line;
  for (const std::string& name : names) {
    line.image = name;
    baselines.Add(line);
    line.index += index_step;
  }
  return baselines.Describe();
}

TEST(Baselines, TellPicturesChosenFromAVideoByTheirNumbers) {
  EXPECT_THAT(OfNames({"a_0.jpg", "a_6.jpg", "a_12.jpg", "a_18.jpg"}),
              HasSubstr("numbers go up by 6 (a_0.jpg, a_6.jpg)"));
  EXPECT_THAT(OfNames({"cam0/0001.v2", "cam0/0003.v2", "cam0/0005.v2", "cam0/0007.v2"}),
              HasSubstr("numbers go up by 2"));
}

TEST(Baselines, SayNothingOfOtherNames) {
  EXPECT_EQ(OfNames({"0.png", "1.png", "2.png", "3.png"}), "");
  EXPECT_EQ(OfNames({"0.png", "6.png", "12.png"}), "") << "too few to tell";
  EXPECT_EQ(OfNames({"0.png", "6.png", "12.png", "19.png"}), "") << "photographs";
  EXPECT_EQ(OfNames({"0.png", "7.png", "13.png", "19.png"}), "");
  EXPECT_EQ(OfNames({"0.png", "6.png", "a.png", "12.png", "18.png"}), "");
  EXPECT_EQ(OfNames({"", "", "", ""}), "") << "older runs";
  EXPECT_EQ(OfNames({"0.png", "6.png", "12.png", "18.png"}, 6), "") << "a run's own choice";
  EXPECT_EQ(OfNames({"1000.png", "1100.png", "1200.png", "1300.png"}), "") << "milliseconds";
}

FrameLine Line(const std::string& doubt, FrameLine::Outcome outcome, const std::string& reason) {
  return {.outcome = outcome, .reason = reason, .doubt = doubt};
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

TEST(LineLog, GrowsByWholeLines) {
  const std::string path = FreshFolder() + "/log";
  {
    LineLog log = Value(LineLog::Open(path));
    ASSERT_TRUE(log.Append("one").ok());
    ASSERT_TRUE(log.Append("two").ok());
  }
  EXPECT_EQ(*ReadFile(path), "one\ntwo\n");
}

TEST(LineLog, CutsOffWhatACrashLeft) {
  const std::string path = FreshFolder() + "/log";
  std::ofstream(path) << "one\ntwo\nthr";
  ASSERT_TRUE(LineLog::Open(path)->Append("three").ok());
  EXPECT_EQ(*ReadFile(path), "one\ntwo\nthree\n");
  ASSERT_TRUE(LineLog::OpenTruncated(path, 1)->Append("zwei").ok());
  EXPECT_EQ(*ReadFile(path), "one\nzwei\n");
  EXPECT_EQ(LineLog::OpenTruncated(path, 3).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(*ReadFile(path), "one\nzwei\n");
}

// A limit on the file size stands for a full disk: the write fails after a part of the bytes.
TEST(LineLog, AFullDiskLeavesWholeLines) {
  const std::string path = FreshFolder() + "/log";
  const rlimit limit{100, 100};
  EXPECT_EXIT(
      {
        signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &limit);
        absl::StatusOr<LineLog> log = LineLog::Open(path);
        const bool fits = log->Append(std::string(60, 'a')).ok();
        const bool does_not = !log->Append(std::string(60, 'b')).ok();
        _exit(fits && does_not && log->Append("c").ok() ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
  EXPECT_EQ(*ReadFile(path), std::string(60, 'a') + "\nc\n");
}

}  // namespace
}  // namespace egosieve::tools
