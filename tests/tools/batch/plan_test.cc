// A batch as numbered tasks: what each runs, what it needs, and that all of them, in any number of
// processes, give what one machine gives.
#include "tools/batch/plan.h"

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fresh_folder.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(BatchPlan, NumbersStageByStageAndNeedsWhatComesBefore) {
  const BatchPlan plan({{"a.mp4", "out/a", {}}, {"b.mp4", "out/b", {}}}, 3, 0);
  ASSERT_EQ(plan.stages().size(), 6u);
  EXPECT_EQ(plan.task_count(), 12);
  EXPECT_EQ(plan.stages()[2].name, "infer 2/3");
  EXPECT_THAT(plan.stages()[0].needs, ElementsAre());
  EXPECT_THAT(plan.stages()[3].needs, ElementsAre(0));
  EXPECT_THAT(plan.stages()[4].needs, ElementsAre(1, 2, 3));
  EXPECT_THAT(plan.stages()[5].needs, ElementsAre(4));
  EXPECT_EQ(plan.TaskNumber(4, 1), 9);
}

TEST(BatchPlan, TasksHaveTheDrivesFlags) {
  const BatchPlan plan({{"a.mp4", "out/a", {"--stride=2", "--device=cpu"}}}, 2, 4);
  EXPECT_THAT(plan.Arguments(0, 0),
              ElementsAre("segment", "a.mp4", "--out=out/a", "--resume", "--stride=2",
                          "--device=cpu", "--learn_only", "--threads=4", "--progress=none"));
  EXPECT_THAT(plan.Arguments(2, 0), ElementsAre("infer", "out/a", "--shard=2/2", "--device=cpu",
                                                "--threads=4", "--progress=none"));
  EXPECT_THAT(plan.Arguments(4, 0), ElementsAre("report", "out/a"));
  const BatchPlan own({{"a.mp4", "out/a", {"--learn_only", "--threads=1"}}}, 1, 4);
  EXPECT_THAT(own.Arguments(0, 0), ElementsAre("segment", "a.mp4", "--out=out/a", "--resume",
                                               "--learn_only", "--threads=1", "--progress=none"));
}

TEST(BatchPlan, ATaskThatNeedsAnotherSaysWhich) {
  const std::string out = FreshFolder() + "/none";
  const BatchPlan plan({{"a.mp4", out, {}}}, 2, 0);
  EXPECT_TRUE(plan.ArgumentsOfReadyTask(0).ok());
  const absl::Status early = plan.ArgumentsOfReadyTask(2).status();
  EXPECT_EQ(early.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(early.message()), HasSubstr("--task=0"));
  EXPECT_EQ(plan.ArgumentsOfReadyTask(5).status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(plan.ArgumentsOfReadyTask(-1).status().code(), absl::StatusCode::kOutOfRange);
}

class BatchTasks : public testing::Test {
 protected:
  BatchTasks() : root_(FreshFolder()) {
    std::string manifest;
    for (const std::string drive : {"a", "b"}) {
      WritePatchDrive(root_ + "/" + drive, SmallPatchDrive(8));
      absl::StrAppend(&manifest, "[", drive, "]\npath = \"", drive, "/frames\"\nout = \"out/",
                      drive, "\"\n", "budget = 100\nstride = 8\ncheckpoint_every = 3\n");
    }
    EXPECT_TRUE(WriteFileAtomically(root_ + "/drives.toml", manifest).ok());
  }

  ProgramOutcome RunBatch(const std::vector<std::string>& flags) const {
    std::vector<std::string> words = {"batch", root_ + "/drives.toml"};
    words.insert(words.end(), flags.begin(), flags.end());
    return RunProgram(words);
  }

  std::string root_;
};

TEST_F(BatchTasks, OneAfterTheOtherTheyGiveWhatOneMachineGives) {
  for (int task = 0; task < 8; ++task) {
    const ProgramOutcome outcome = RunBatch({"--shards=1", absl::StrCat("--task=", task)});
    EXPECT_EQ(outcome.code, 0) << task << ": " << outcome.err;
  }
  const ProgramOutcome status = RunBatch({"--status", "--shards=1"});
  EXPECT_THAT(status.out, ContainsRegex("/out/a +done +8 +0 +8 of 8 +done +done"));
  EXPECT_THAT(status.out, ContainsRegex("/out/b +done +8 +0 +8 of 8 +done +done"));
  ASSERT_EQ(RunProgram({"segment", root_ + "/a/frames", "--out=" + root_ + "/alone", "--budget=100",
                        "--stride=8", "--checkpoint_every=3"})
                .code,
            0);
  ASSERT_EQ(RunProgram({"reconstruct", root_ + "/alone"}).code, 0);
  for (const std::string file :
       {"grid/000004.prob.png", "masks/000004.png", "ids/000007.png", "tracks.csv"}) {
    const absl::StatusOr<std::string> alone = ReadFile(root_ + "/alone/" + file);
    ASSERT_TRUE(alone.ok()) << alone.status();
    EXPECT_EQ(*alone, ReadFile(root_ + "/out/a/" + file).value_or("none")) << file;
  }
  // Once more does no harm.
  EXPECT_EQ(RunBatch({"--shards=1", "--task=0"}).code, 0);
}

TEST_F(BatchTasks, StatusTellsWhatIsThereAtAnyTime) {
  EXPECT_THAT(RunBatch({"--status"}).out, ContainsRegex("/out/a +not started +0 +0 +0 of 0 +- +-"));
  ASSERT_EQ(RunBatch({"--task=0"}).code, 0);
  ASSERT_EQ(RunBatch({"--task=2"}).code, 0);
  EXPECT_THAT(RunBatch({"--status"}).out, ContainsRegex("/out/a +done +8 +0 +5 of 8 +- +-"));
  const ProgramOutcome early = RunBatch({"--task=6"});
  EXPECT_EQ(early.code, 2);
  EXPECT_THAT(early.err, HasSubstr("'infer 2/2'"));
  EXPECT_EQ(CountLines(early.err), 1);
  EXPECT_THAT(RunBatch({"--plan"}).out, ContainsRegex(" 9  .*/out/b  report\n"));
  EXPECT_EQ(RunBatch({"--plan", "--task=1"}).code, 2);
  ASSERT_TRUE(WriteFileAtomically(root_ + "/out/a/run.json", "{").ok());
  EXPECT_THAT(RunBatch({"--status"}).out, ContainsRegex("/out/a +unreadable .*run.json"));
}

}  // namespace
}  // namespace egosieve::tools
