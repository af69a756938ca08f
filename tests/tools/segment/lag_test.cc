// segment --lag, in seconds, against --ahead, in frames.
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "kernels/files/atomic_file.h"
#include "tests/tools/testing/fresh_folder.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

class Lag : public ::testing::Test {
 protected:
  void SetUp() override { WritePatchDrive(root_, SmallPatchDrive(3)); }

  ProgramOutcome Segment(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"segment", root_ + "/frames", "--out=" + run_, "--overwrite",
                                      "--progress=none"};
    words.insert(words.end(), more.begin(), more.end());
    return RunProgram(words);
  }
  std::string FramesAhead() const {
    return RunFolder::Open(run_)->ReadDescription()->flags.at("ahead");
  }

  const std::string root_ = FreshFolder(), run_ = root_ + "/run";
};

TEST_F(Lag, IsInSecondsOfTheInput) {
  ASSERT_EQ(Segment({"--lag=0.2"}).code, 0);
  EXPECT_EQ(FramesAhead(), "2");
  ASSERT_EQ(Segment({"--lag=0.2", "--fps=30"}).code, 0);
  EXPECT_EQ(FramesAhead(), "6");
  ASSERT_EQ(Segment({"--lag=0.2", "--fps=30", "--skip=1"}).code, 0);
  EXPECT_EQ(FramesAhead(), "3");
  ASSERT_EQ(Segment({"--lag=0"}).code, 0);
  EXPECT_EQ(FramesAhead(), "0");
}

TEST_F(Lag, GivesTheBytesOfAsManyFramesAhead) {
  WritePatchDrive(root_, SmallPatchDrive(16));
  std::vector<std::string> maps, cameras;
  for (const char* flag : {"--ahead=2", "--lag=0.2"}) {
    ASSERT_EQ(Segment({flag}).code, 0);
    cameras.push_back(*ReadFile(run_ + "/camera.json"));
    maps.push_back(*ReadFile(run_ + "/grid/000008.prob.png"));
  }
  EXPECT_EQ(cameras[0], cameras[1]);
  EXPECT_EQ(maps[0], maps[1]);
}

TEST_F(Lag, IsRefusedBesideFramesAheadAndWhereItIsTooLong) {
  EXPECT_EQ(Segment({"--lag=0.2", "--ahead=2"}).code, 2);
  const ProgramOutcome outcome = Segment({"--lag=10", "--fps=30"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--lag=10 is 300 frames here; at most 100"));
}

}  // namespace
}  // namespace egosieve::tools
