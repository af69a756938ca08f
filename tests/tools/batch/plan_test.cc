// A batch as numbered tasks: what each runs, what it needs, and that all of them, in any number of
// processes, give what one machine gives.
#include "tools/batch/plan.h"

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fresh_folder.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/batch/drive_cuts.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> StageNames(const BatchPlan& plan) {
  std::vector<std::string> names;
  for (const PlanStage& stage : plan.stages()) names.push_back(stage.name);
  return names;
}

TEST(BatchPlan, NumbersStageByStageAndNeedsWhatComesBefore) {
  const BatchPlan plan({{"a.mp4", "out/a", {}}, {"b.mp4", "out/b", {}}}, 0);
  EXPECT_THAT(StageNames(plan), ElementsAre("segment", "reconstruct", "report"));
  EXPECT_EQ(plan.task_count(), 6);
  EXPECT_THAT(plan.stages()[0].needs, ElementsAre());
  EXPECT_THAT(plan.stages()[1].needs, ElementsAre(0));
  EXPECT_THAT(plan.stages()[2].needs, ElementsAre(1));
  EXPECT_EQ(plan.TaskNumber(2, 1), 5);
}

TEST(BatchPlan, StepsNeedTheMapsAndTheMasksBeforeThem) {
  const BatchStep masks = {"masks", {"--for=colmap"}}, infer = {"infer", {}};
  const BatchStep reconstruct = {"reconstruct", {"--causal"}}, render = {"render", {}};
  const BatchPlan plan({{"a.mp4", "out/a", {}, {infer, reconstruct, masks, render}}}, 0);
  EXPECT_THAT(StageNames(plan), ElementsAre("segment", "infer", "reconstruct", "masks", "render"));
  EXPECT_THAT(plan.stages()[1].needs, ElementsAre(0));
  EXPECT_THAT(plan.stages()[2].needs, ElementsAre(1));
  EXPECT_THAT(plan.stages()[3].needs, ElementsAre(2));
  EXPECT_THAT(plan.stages()[4].needs, ElementsAre(2));
  EXPECT_THAT(plan.Arguments(2, 0),
              ElementsAre("reconstruct", "out/a", "--resume", "--causal", "--progress=none"));
  EXPECT_THAT(plan.Arguments(3, 0), ElementsAre("masks", "out/a", "--out=out/a.masks",
                                                "--overwrite", "--for=colmap", "--progress=none"));
  EXPECT_TRUE(CheckThen({{"a", "a", {}, {masks}}, {"b", "b", {}, {masks}}}).ok());
  EXPECT_EQ(CheckThen({{"a", "a", {}, {masks}}, {"b", "b", {}, {render}}}).code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(BatchPlan, TasksHaveTheDrivesFlags) {
  const BatchPlan plan({{"a.mp4", "out/a", {"--stride=2", "--device=cpu"}}}, 4);
  EXPECT_THAT(plan.Arguments(0, 0),
              ElementsAre("segment", "a.mp4", "--out=out/a", "--resume", "--stride=2",
                          "--device=cpu", "--threads=4", "--progress=none"));
  EXPECT_THAT(plan.Arguments(1, 0), ElementsAre("reconstruct", "out/a", "--resume", "--device=cpu",
                                                "--threads=4", "--progress=none"));
  EXPECT_THAT(plan.Arguments(2, 0), ElementsAre("report", "out/a"));
  const BatchPlan own({{"a.mp4", "out/a", {"--learn_only", "--threads=1"}}}, 4);
  EXPECT_THAT(own.Arguments(0, 0), ElementsAre("segment", "a.mp4", "--out=out/a", "--resume",
                                               "--learn_only", "--threads=1", "--progress=none"));
}

TEST(BatchPlan, ATaskThatNeedsAnotherSaysWhich) {
  const std::string out = FreshFolder() + "/none";
  const BatchPlan plan({{"a.mp4", out, {}}}, 0);
  EXPECT_TRUE(plan.ArgumentsOfReadyTask(0).ok());
  const absl::Status early = plan.ArgumentsOfReadyTask(2).status();
  EXPECT_EQ(early.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(early.message()), HasSubstr("--task=1"));
  EXPECT_EQ(plan.ArgumentsOfReadyTask(3).status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(plan.ArgumentsOfReadyTask(-1).status().code(), absl::StatusCode::kOutOfRange);
}

TEST(BatchPlan, CutDrivesAreLearntInPiecesThatOverlap) {
  const BatchPlan plan({{"a.mp4", "out/a", {"--stride=2"}, {}, {100, 250}}, {"b.mp4", "out/b", {}}},
                       0);
  EXPECT_THAT(StageNames(plan), ElementsAre("segment 1/3", "segment 2/3", "segment 3/3", "merge",
                                            "reconstruct", "report"));
  EXPECT_THAT(plan.stages()[3].needs, ElementsAre(0, 1, 2));
  EXPECT_THAT(plan.stages()[4].needs, ElementsAre(3));
  EXPECT_THAT(plan.Arguments(0, 0), ElementsAre("segment", "a.mp4", "--out=out/a", "--resume",
                                                "--stride=2", "--to=99", "--progress=none"));
  EXPECT_THAT(plan.Arguments(1, 0),
              ElementsAre("segment", "a.mp4", "--out=out/a.pieces/2", "--resume", "--stride=2",
                          "--from=90", "--to=249", "--progress=none"));
  EXPECT_THAT(plan.Arguments(2, 0),
              ElementsAre("segment", "a.mp4", "--out=out/a.pieces/3", "--resume", "--stride=2",
                          "--from=240", "--progress=none"));
  EXPECT_THAT(plan.Arguments(3, 0),
              ElementsAre("merge", "out/a", "out/a.pieces/2", "out/a.pieces/3", "--progress=none"));
  // A drive in one piece.
  EXPECT_THAT(plan.Arguments(0, 1),
              ElementsAre("segment", "b.mp4", "--out=out/b", "--resume", "--progress=none"));
  for (const int task : {3, 5, 7}) {
    EXPECT_THAT(*plan.ArgumentsOfReadyTask(task), ElementsAre()) << task;
  }
  EXPECT_EQ(plan.LongestPiece(300), 300) << "a drive in one piece";
  EXPECT_EQ(BatchPlan({{"a", "a", {}, {}, {100, 250}}}, 0).LongestPiece(300), 160);
  EXPECT_EQ(BatchPlan({{"a", "a", {}, {}, {100, 250}}}, 0).LongestPiece(500), 260);
}

TEST(BatchPlan, PiecesExcludeFlagsThatChooseFrames) {
  EXPECT_TRUE(CheckCuts({{"a", "a", {"--to=5"}}, {"b", "b", {"--stride=2"}, {}, {10}}}).ok());
  EXPECT_TRUE(CheckCuts({{"b", "b", {"--learn_only=false"}, {}, {10}}}).ok());
  for (const char* flag : {"--from=3", "--to=5", "--max_frames=9", "--learn_only"}) {
    EXPECT_EQ(CheckCuts({{"b", "b", {flag}, {}, {10}}}).code(), absl::StatusCode::kInvalidArgument)
        << flag;
  }
}

TEST(DriveCuts, AreTheFewestPiecesOfEqualLength) {
  EXPECT_THAT(EqualCuts(3000, 0.1, 5), ElementsAre());
  EXPECT_THAT(EqualCuts(3001, 0.1, 5), ElementsAre(1500));
  EXPECT_THAT(EqualCuts(9001, 0.1, 5), ElementsAre(2250, 4500, 6750));
  EXPECT_THAT(EqualCuts(3, 1.0, 1e-9), ElementsAre(1, 2)) << "no piece is empty";
  EXPECT_THAT(EqualCuts(-1, 0.1, 5), ElementsAre()) << "a length that no header tells";
}

TEST(DriveCuts, AtScenesArePiecesOfWholeScenes) {
  // 600 frames a piece at most.
  EXPECT_THAT(CutsAtScenes(600, {300}, 0.1, 1), ElementsAre()) << "one piece holds both";
  EXPECT_THAT(CutsAtScenes(900, {}, 0.1, 1), ElementsAre(450));
  EXPECT_THAT(CutsAtScenes(900, {200, 500}, 0.1, 1), ElementsAre(500));
  EXPECT_THAT(CutsAtScenes(1500, {100, 400, 800, 1300}, 0.1, 1), ElementsAre(400, 800, 1300));
  EXPECT_THAT(CutsAtScenes(1600, {100, 1500}, 0.1, 1), ElementsAre(100, 566, 1033))
      << "a long scene in thirds, and the short one joins its last";
  EXPECT_THAT(CutsAtScenes(1000, {1, 999}, 0.1, 1), ElementsAre(1, 500));
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
  const auto run = [&](const std::string& flag, const std::string& masks = "--for=colmap") {
    return RunBatch({flag, "--then=reconstruct,masks,render,report", "--masks_flags=" + masks});
  };
  for (int task = 0; task < 10; task += 2) {  // those of the first drive
    const ProgramOutcome outcome = run(absl::StrCat("--task=", task));
    EXPECT_EQ(outcome.code, 0) << task << ": " << outcome.err;
  }
  const ProgramOutcome status = run("--status");
  EXPECT_THAT(status.out, ContainsRegex("/out/a +done +8 +0 +8 of 8 +done +done"));
  EXPECT_THAT(status.out, ContainsRegex("/out/b +not started +0 +0 +0 of 0 +- +-"));
  const std::string alone = root_ + "/alone";
  ASSERT_EQ(RunProgram({"segment", root_ + "/a/frames", "--out=" + alone, "--budget=100",
                        "--stride=8", "--checkpoint_every=3"})
                .code,
            0);
  ASSERT_EQ(RunProgram({"reconstruct", alone}).code, 0);
  ASSERT_EQ(RunProgram({"masks", alone, "--for=colmap", "--out=" + alone + ".masks"}).code, 0);
  for (const std::string file : {"/grid/000004.prob.png", "/masks/000004.png", "/ids/000007.png",
                                 "/tracks.csv", ".masks/000005.png.png"}) {
    const absl::StatusOr<std::string> expected = ReadFile(alone + file);
    ASSERT_TRUE(expected.ok()) << expected.status();
    EXPECT_EQ(*expected, ReadFile(root_ + "/out/a" + file).value_or("none")) << file;
  }
  // What is done is left, and done again with other flags.
  const std::string mask = root_ + "/out/a.masks/000005.png.png";
  std::filesystem::remove(mask);
  EXPECT_EQ(run("--task=0").code, 0);
  EXPECT_EQ(run("--task=4").code, 0);
  EXPECT_FALSE(std::filesystem::exists(mask));
  EXPECT_EQ(run("--task=4", "--for=colmap --dilate=2").code, 0);
  EXPECT_TRUE(std::filesystem::exists(mask));
  // A batch on this machine reads the same book: it finds all that tasks have done.
  EXPECT_THAT(
      RunBatch({"--then=reconstruct,masks,render,report", "--masks_flags=--for=colmap --dilate=2"})
          .out,
      ContainsRegex("/out/a +was done"));
}

TEST_F(BatchTasks, PiecesAreMergedAsByHand) {
  WritePatchDrive(root_ + "/a", SmallPatchDrive(16));  // 1.6 s, b 0.8 s
  const auto run = [&](const std::string& flag) {
    return RunBatch({flag, "--piece_minutes=0.014"});
  };
  EXPECT_THAT(run("--plan").out, ContainsRegex(" 0  .*/out/a  +segment 1/2\n"
                                               " +1  .*/out/b  +segment 1/2\n"
                                               " +2  .*/out/a  +segment 2/2\n"
                                               " +4  .*/out/a  +merge\n"));
  EXPECT_THAT(run("--task=4").err, HasSubstr("'segment 1/2'"));
  for (int task = 0; task < 10; task += 2) {  // the first drive, to its report
    const ProgramOutcome outcome = run(absl::StrCat("--task=", task));
    EXPECT_EQ(outcome.code, 0) << task << ": " << outcome.err;
  }
  EXPECT_EQ(run("--task=3").code, 0) << "nothing to do";
  EXPECT_THAT(run("--status").out, ContainsRegex("/out/a +done +16 +0 +16 of 16 +done +done"));
  EXPECT_THAT(run("--status").out, ContainsRegex("/out/a.pieces/2 +done +15 +0 +15 of 15"));
  const auto segment = [&](const std::string& name, const std::string& part) {
    return RunProgram({"segment", root_ + "/a/frames", "--out=" + root_ + "/" + name,
                       "--budget=100", "--stride=8", "--checkpoint_every=3", part})
        .code;
  };
  ASSERT_EQ(segment("p1", "--to=7"), 0);
  ASSERT_EQ(segment("p2", "--from=1"), 0);
  ASSERT_EQ(RunProgram({"merge", root_ + "/p1", root_ + "/p2"}).code, 0);
  for (const char* file : {"/grid/000004.prob.png", "/grid/000012.prob.png"}) {
    const absl::StatusOr<std::string> expected = ReadFile(root_ + "/p1" + file);
    ASSERT_TRUE(expected.ok()) << expected.status();
    EXPECT_EQ(*expected, ReadFile(root_ + "/out/a" + file).value_or("none")) << file;
  }
  const ProgramOutcome here = RunBatch({"--piece_minutes=1"});
  EXPECT_EQ(here.code, 2);
  EXPECT_THAT(here.err, HasSubstr("--engine=slurm or --task"));
}

TEST_F(BatchTasks, PiecesEndWithScenes) {
  const PatchDriveOptions scene = SmallPatchDrive(16);
  WritePatchDrive(root_ + "/a", scene);
  for (int i = 10; i < 16; ++i) {  // another scene: the same upside down
    cv::Mat turned;
    cv::flip(PatchFrame(scene, i), turned, 0);
    ASSERT_TRUE(cv::imwrite(root_ + absl::StrFormat("/a/frames/%06d.png", i), turned));
  }
  const auto plan = [&] {
    return RunBatch({"--plan", "--json", "--piece_minutes=0.02", "--scene_cuts"});
  };
  const ProgramOutcome found = plan();
  EXPECT_THAT(found.out, HasSubstr("\"--to=9\""));
  EXPECT_THAT(found.err, HasSubstr("looking for scene cuts in"));
  // It is kept, and told the tasks; another length of the input makes it void.
  const std::string notes = root_ + "/out/egosieve_logs/a.tasks/scenes.json";
  const std::string kept = ReadFile(notes).value_or("");
  EXPECT_THAT(kept, HasSubstr("\"frames\":16,\"cuts\":[10]"));
  ASSERT_TRUE(WriteFileAtomically(notes, absl::StrReplaceAll(kept, {{"[10]", "[7]"}})).ok());
  const ProgramOutcome known = plan();
  EXPECT_THAT(known.out, HasSubstr("\"--to=6\""));
  EXPECT_THAT(known.err, Not(HasSubstr("/a/frames")));
  std::filesystem::remove(root_ + "/a/frames/000015.png");
  EXPECT_THAT(plan().out, HasSubstr("\"--to=9\""));
  const ProgramOutcome bare = RunBatch({"--plan", "--scene_cuts"});
  EXPECT_EQ(bare.code, 2);
  EXPECT_THAT(bare.err, HasSubstr("--piece_minutes"));
}

TEST_F(BatchTasks, StatusTellsWhatIsThereAtAnyTime) {
  EXPECT_THAT(RunBatch({"--status"}).out, ContainsRegex("/out/a +not started +0 +0 +0 of 0 +- +-"));
  ASSERT_EQ(RunBatch({"--task=0"}).code, 0);
  EXPECT_THAT(RunBatch({"--status"}).out, ContainsRegex("/out/a +done +8 +0 +8 of 8 +- +-"));
  const ProgramOutcome early = RunBatch({"--task=4"});
  EXPECT_EQ(early.code, 2);
  EXPECT_THAT(early.err, HasSubstr("'reconstruct'"));
  EXPECT_EQ(CountLines(early.err), 1);
  EXPECT_THAT(RunBatch({"--plan"}).out, ContainsRegex(" 3  .*/out/b  reconstruct\n"));
  EXPECT_EQ(RunBatch({"--plan", "--task=1"}).code, 2);
  ASSERT_TRUE(WriteFileAtomically(root_ + "/out/a/run.json", "{").ok());
  EXPECT_THAT(RunBatch({"--status"}).out, ContainsRegex("/out/a +unreadable .*run.json"));
}

}  // namespace
}  // namespace egosieve::tools
