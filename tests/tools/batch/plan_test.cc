// A batch as numbered tasks: what each runs, what it needs, and that all of them, in any number of
// processes, give what one machine gives.
#include "tools/batch/plan.h"

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> StageNames(const BatchPlan& plan) {
  std::vector<std::string> names;
  for (size_t stage = 0; stage < plan.stages(); ++stage) {
    names.push_back(plan.tasks()[plan.Number(stage, 0)].stage);
  }
  return names;
}

BatchPlan Plan(const std::vector<BatchDrive>& drives) { return Value(BatchPlan::Create(drives)); }

const std::vector<std::string> kUsual = {"refine", "report"};

TEST(BatchPlan, NumbersStageByStageAndNeedsWhatComesBefore) {
  const BatchPlan plan = Plan({{"/a.mp4", "/out/a", {}, kUsual}, {"/b.mp4", "/out/b", {}, kUsual}});
  EXPECT_THAT(StageNames(plan), ElementsAre("segment", "refine", "report"));
  ASSERT_EQ(plan.tasks().size(), 6u);
  EXPECT_THAT(plan.tasks()[1].needs, ElementsAre());
  EXPECT_THAT(plan.tasks()[3].needs, ElementsAre(1));
  EXPECT_THAT(plan.tasks()[5].needs, ElementsAre(3));
  EXPECT_EQ(plan.Number(2, 1), 5u);
  EXPECT_EQ(plan.DriveOf(5).out, "/out/b");
}

TEST(BatchPlan, StepsNeedTheMapsAndTheMasksBeforeThem) {
  const BatchPlan plan = Plan({{"/a.mp4",
                                "/out/a",
                                {{"segment", {"--device=cpu"}},
                                 {"refine", {"--causal"}},
                                 {"masks", {"--for=colmap"}},
                                 {"render", {"--threads=2"}}},
                                {"refine", "masks", "render"}}});
  EXPECT_THAT(StageNames(plan), ElementsAre("segment", "refine", "masks", "render"));
  const std::vector<BatchTask>& tasks = plan.tasks();
  EXPECT_THAT(tasks[1].needs, ElementsAre(0));
  EXPECT_THAT(tasks[2].needs, ElementsAre(1));
  EXPECT_THAT(tasks[3].needs, ElementsAre(1));
  EXPECT_THAT(tasks[0].arguments, ElementsAre("segment", "/a.mp4", "--out=/out/a", "--resume",
                                              "--device=cpu", "--progress=none"));
  EXPECT_THAT(tasks[1].arguments,
              ElementsAre("refine", "/out/a", "--resume", "--causal", "--progress=none"));
  EXPECT_THAT(tasks[2].arguments, ElementsAre("masks", "/out/a", "--out=/out/a.masks",
                                              "--overwrite", "--for=colmap", "--progress=none"));
  EXPECT_THAT(tasks[3].arguments,
              ElementsAre("render", "/out/a", "--threads=2", "--progress=none"));
  const auto refused = [](const BatchDrive& a, const BatchDrive& b) {
    return BatchPlan::Create({a, b}).status().code() == absl::StatusCode::kInvalidArgument;
  };
  EXPECT_FALSE(refused({"/a", "/out/a"}, {"/b", "/out/b"}));
  EXPECT_TRUE(refused({"/a", "/out/a", {}, {"masks"}}, {"/b", "/out/b", {}, {"render"}}));
  EXPECT_TRUE(refused({"/a", "/out/a"}, {"/b", "/out/a"}));
}

TEST(BatchPlan, CutDrivesAreLearntInPiecesThatOverlap) {
  const BatchPlan plan =
      Plan({{"/a.mp4", "/out/a", {{"segment", {"--stride=2"}}}, kUsual, {100, 250}},
            {"/b.mp4", "/out/b", {}, kUsual}});
  EXPECT_THAT(StageNames(plan),
              ElementsAre("segment_1", "segment_2", "segment_3", "merge", "refine", "report"));
  const auto task = [&](size_t stage, size_t drive) {
    return plan.tasks()[plan.Number(stage, drive)];
  };
  EXPECT_THAT(task(2, 0).needs, ElementsAre());
  EXPECT_THAT(task(3, 0).needs, ElementsAre(0, 2, 4));
  EXPECT_THAT(task(4, 0).needs, ElementsAre(6));
  EXPECT_THAT(task(0, 0).arguments, ElementsAre("segment", "/a.mp4", "--out=/out/a", "--resume",
                                                "--stride=2", "--to=99", "--progress=none"));
  EXPECT_THAT(task(1, 0).arguments,
              ElementsAre("segment", "/a.mp4", "--out=/out/a.pieces/2", "--resume", "--stride=2",
                          "--from=90", "--to=249", "--progress=none"));
  EXPECT_THAT(task(2, 0).arguments,
              ElementsAre("segment", "/a.mp4", "--out=/out/a.pieces/3", "--resume", "--stride=2",
                          "--from=240", "--progress=none"));
  EXPECT_THAT(task(3, 0).arguments, ElementsAre("merge", "/out/a", "/out/a.pieces/2",
                                                "/out/a.pieces/3", "--progress=none"));
  // A drive in one piece.
  EXPECT_THAT(task(0, 1).arguments,
              ElementsAre("segment", "/b.mp4", "--out=/out/b", "--resume", "--progress=none"));
  for (const size_t stage : {1, 2, 3}) {
    EXPECT_THAT(task(stage, 1).arguments, ElementsAre());
    EXPECT_TRUE(plan.IsDone(plan.Number(stage, 1)));
  }
}

TEST(BatchPlan, IsReadAsItIsWritten) {
  const BatchPlan plan =
      Plan({{"/in/a", "/out/a", {{"masks", {"--for=coco"}}}, {"masks"}, {50, 90}},
            {"/in/b", "/out/b", {}, {"masks"}}});
  const BatchPlan read = Value(BatchPlan::FromText(plan.ToText()));
  ASSERT_EQ(read.tasks().size(), plan.tasks().size());
  for (size_t i = 0; i < plan.tasks().size(); ++i) {
    EXPECT_EQ(read.tasks()[i].stage, plan.tasks()[i].stage);
    EXPECT_EQ(read.tasks()[i].folder, plan.tasks()[i].folder);
    EXPECT_EQ(read.tasks()[i].arguments, plan.tasks()[i].arguments);
    EXPECT_EQ(read.tasks()[i].needs, plan.tasks()[i].needs);
  }
  EXPECT_EQ(read.DriveOf(3).path, "/in/b");
  for (const char* text :
       {"", "[]", "{\"drives\": [], \"tasks\": []}", "[{\"path\": \"a\", \"out\": \"b\"}]",
        R"({"drives": [{"path": "a", "run": "b"}],
            "tasks": [{"stage": "x", "run": "b", "arguments": ["x"], "needs": [0]}]})",
        R"({"drives": [{"path": "a", "run": "b"}, {"path": "c", "run": "d"}],
            "tasks": [{"stage": "x", "run": "b", "arguments": ["x"], "needs": []}]})"}) {
    EXPECT_THAT(BatchPlan::FromText(text), IsInvalid()) << text;
  }
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
    return RunProgram(std::vector<std::string>{"batch", root_ + "/drives.toml"} + flags);
  }

  std::string root_;
};

TEST_F(BatchTasks, OneAfterTheOtherTheyGiveWhatOneMachineGives) {
  const auto run = [&](const std::string& flag, const std::string& masks = "--for=colmap") {
    return RunBatch({flag, "--then=refine,masks,render,report", "--masks_flags=" + masks});
  };
  for (int task = 0; task < 10; task += 2) {  // those of the first drive
    EXPECT_THAT(run(absl::StrCat("--task=", task)), Succeeds()) << task;
  }
  const ProgramOutcome status = run("--status");
  EXPECT_THAT(status.out, ContainsRegex("/out/a +done +5 of 5 +0 +8 +0 "));
  EXPECT_THAT(status.out, ContainsRegex("/out/b +not started +0 of 5 +0 +0 +0 "));
  const std::string alone = root_ + "/alone";
  ASSERT_THAT(RunProgram({"segment", root_ + "/a/frames", "--out=" + alone, "--budget=100",
                          "--stride=8", "--checkpoint_every=3"}),
              Succeeds());
  ASSERT_THAT(RunProgram({"refine", alone}), Succeeds());
  ASSERT_THAT(RunProgram({"masks", alone, "--for=colmap", "--out=" + alone + ".masks"}),
              Succeeds());
  for (const std::string file : {"/grid/000004.prob.png", "/masks/000004.png", "/ids/000007.png",
                                 "/tracks.csv", ".masks/000005.png.png"}) {
    const std::string expected = Value(ReadFile(alone + file));
    EXPECT_EQ(expected, ReadFile(root_ + "/out/a" + file).value_or("none")) << file;
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
  const auto time = std::filesystem::last_write_time(root_ + "/out/a/report.html");
  const auto render = [&](const std::string& flags) {
    return RunBatch({"--then=refine,masks,render,report", "--masks_flags=" + flags}).code;
  };
  EXPECT_EQ(render("--for=colmap --dilate=2"), 0);
  EXPECT_EQ(std::filesystem::last_write_time(root_ + "/out/a/report.html"), time);
}

// What was made of the masks is made again where they are others.
TEST_F(BatchTasks, WhatNeedsAnotherStepIsDoneAgainWithIt) {
  const auto report_time = [&](const std::string& flags) {
    std::string manifest = *ReadFile(root_ + "/drives.toml");
    manifest = "[defaults]\nrefine = {" + flags + "}\n" + manifest.substr(0, manifest.find("[b]"));
    EXPECT_TRUE(WriteFileAtomically(root_ + "/own.toml", manifest).ok());
    EXPECT_THAT(RunProgram({"batch", root_ + "/own.toml"}), Succeeds());
    return std::filesystem::last_write_time(root_ + "/out/a/report.html");
  };
  const auto first = report_time("");
  EXPECT_EQ(report_time(""), first);
  EXPECT_NE(report_time("causal = true"), first);
}

TEST_F(BatchTasks, PiecesAreMergedAsByHand) {
  WritePatchDrive(root_ + "/a", SmallPatchDrive(16));  // 1.6 s, b 0.8 s
  EXPECT_THAT(RunBatch({"--plan", "--piece_minutes=0.014"}).out,
              ContainsRegex(" 0  .*/out/a  +segment_1\n"
                            " +1  .*/out/b  +segment_1\n"
                            " +2  .*/out/a  +segment_2\n"
                            " +4  .*/out/a  +merge\n"));
  const auto run = [&](const std::string& flag) {
    return RunProgram({"batch", root_ + "/egosieve_jobs/drives/plan.json", flag});
  };
  EXPECT_THAT(run("--task=4").err, HasSubstr("'segment_1'"));
  for (int task = 0; task < 10; task += 2) {  // the first drive, to its report
    EXPECT_THAT(run(absl::StrCat("--task=", task)), Succeeds()) << task;
  }
  EXPECT_EQ(run("--task=3").code, 0) << "nothing to do";
  EXPECT_EQ(run("--task=2").code, 0) << "again";
  EXPECT_THAT(run("--status").out, ContainsRegex("/out/a +done +5 of 5 +0 +16 +0 "));
  const auto segment = [&](const std::string& name, const std::string& part) {
    return RunProgram({"segment", root_ + "/a/frames", "--out=" + root_ + "/" + name,
                       "--budget=100", "--stride=8", "--checkpoint_every=3", part})
        .code;
  };
  ASSERT_EQ(segment("p1", "--to=7"), 0);
  ASSERT_EQ(segment("p2", "--from=1"), 0);
  ASSERT_THAT(RunProgram({"merge", root_ + "/p1", root_ + "/p2"}), Succeeds());
  // Pieces on this machine: the manifest as it is, but for its run folders.
  ASSERT_TRUE(WriteFileAtomically(
                  root_ + "/here.toml",
                  absl::StrReplaceAll(*ReadFile(root_ + "/drives.toml"), {{"\"out/", "\"here/"}}))
                  .ok());
  const ProgramOutcome here =
      RunProgram({"batch", root_ + "/here.toml", "--piece_minutes=0.014", "--jobs=2"});
  ASSERT_EQ(here.code, 0) << here.err << here.out;
  for (const char* file : {"/grid/000004.prob.png", "/grid/000012.prob.png"}) {
    const std::string expected = Value(ReadFile(root_ + "/p1" + file));
    EXPECT_EQ(expected, ReadFile(root_ + "/out/a" + file).value_or("none")) << file;
    EXPECT_EQ(expected, ReadFile(root_ + "/here/a" + file).value_or("none")) << file;
  }
}

TEST_F(BatchTasks, StatusTellsWhatIsThereAtAnyTime) {
  EXPECT_THAT(RunBatch({"--status"}).out, ContainsRegex("/out/a +not started +0 of 3 +0 +0 +0 "));
  ASSERT_THAT(RunBatch({"--task=0"}), Succeeds());
  EXPECT_THAT(RunBatch({"--status"}).out, ContainsRegex("/out/a +begun +1 of 3 +0 +8 +0 "));
  EXPECT_THAT(RunBatch({"--task=4"}), EndsWithLine(2, "'refine'"));
  EXPECT_THAT(RunBatch({"--plan"}).out, ContainsRegex(" 3  .*/out/b  refine\n"));
  EXPECT_EQ(RunBatch({"--plan", "--task=1"}).code, 2);
  EXPECT_EQ(RunBatch({"--task=6"}).code, 2);
  ASSERT_TRUE(WriteFileAtomically(root_ + "/out/a/run.json", "{").ok());
  EXPECT_THAT(RunBatch({"--status"}).out, ContainsRegex("/out/a +failed .*run.json"));
}

}  // namespace
}  // namespace egosieve::tools
