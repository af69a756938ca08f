// A list of drives: what is missing is done, what is there stays, one that fails stops no other.
#include <signal.h>
#include <unistd.h>

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "tests/testing/fresh_folder.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tests/tools/testing/run_comparison.h"
#include "tools/batch/plan.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

class Batch : public testing::Test {
 protected:
  Batch() : root_(FreshFolder()) {
    WritePatchDrive(root_ + "/a", SmallPatchDrive(8));
    WritePatchDrive(root_ + "/b", SmallPatchDrive(8));
  }

  static std::string Entry(const std::string& drive, const std::string& out) {
    return absl::StrFormat("[%s]\npath = '%s/frames'\nout = 'out/%s'\n", out, drive, out);
  }

  void WriteManifest(const std::vector<std::string>& entries) const {
    std::string text = "[defaults]\nbudget = 100\nstride = 8\ncheckpoint_every = 3\nthen = []\n";
    for (const std::string& entry : entries) text += entry;
    ASSERT_TRUE(WriteFileAtomically(root_ + "/drives.toml", text).ok());
  }

  // Starts the batch and sends the signal as soon as the first drive has a line. The batch waits
  // where it tells that it has started this drive, so that it starts no other before.
  int StartAndSend(int signal) const {
    FullPipe told(root_ + "/batch.err");
    const pid_t batch =
        StartProgram({"batch", root_ + "/drives.toml"}, root_ + "/batch.out", root_ + "/batch.err");
    const std::string log = root_ + "/out/a/frames.jsonl";
    std::error_code error;
    EXPECT_TRUE(WaitUntil([&] { return fs::exists(log, error) && fs::file_size(log, error) > 0; }));
    kill(batch, signal);
    told.Empty();
    return WaitForProgram(batch);
  }

  ProgramOutcome RunBatch(int jobs = 1) const {
    return RunProgram({"batch", root_ + "/drives.toml", absl::StrCat("--jobs=", jobs)});
  }

  // A program of this text.
  std::string Program(const std::string& text) const {
    const std::string path = root_ + "/program";
    EXPECT_TRUE(WriteFileAtomically(path, "#!/bin/sh\n" + text + "\n").ok());
    fs::permissions(path, fs::perms::owner_all);
    return path;
  }

  std::string root_;
};

TEST_F(Batch, DoesWhatIsMissingAndToldWhatFailed) {
  WriteManifest({Entry("a", "a"), Entry("nowhere", "gone"), Entry("b", "b")});
  fs::create_directories(root_ + "/out");
  ASSERT_TRUE(WriteFileAtomically(root_ + "/out/a.log", "mine").ok());
  const ProgramOutcome first = RunBatch(2);
  EXPECT_EQ(first.code, 4) << first.err;
  EXPECT_THAT(first.out, ContainsRegex("/out/a +done +1 of 1 +0 +8 +0"));
  EXPECT_THAT(first.out, ContainsRegex("/out/gone +failed +0 of 1 +3 +0 +0 .*nowhere"));
  EXPECT_THAT(first.out, ContainsRegex("/out/b +done +1 of 1 +0 +8 +0"));
  EXPECT_TRUE(fs::exists(root_ + "/out/egosieve_logs/gone/segment.log"));
  EXPECT_EQ(*ReadFile(root_ + "/out/a.log"), "mine");

  // Half of one, and a whole one: they end as if nothing had happened.
  fs::copy(root_ + "/out/b", root_ + "/whole", fs::copy_options::recursive);
  RunDescription description = *RunFolder::Open(root_ + "/out/b")->ReadDescription();
  description.ended = "running";
  ASSERT_TRUE(RunFolder::Open(root_ + "/out/b")->WriteDescription(description).ok());
  ASSERT_TRUE(LineLog::OpenTruncated(root_ + "/out/b/frames.jsonl", 4).ok());
  WriteManifest({Entry("a", "a"), Entry("b", "b")});
  const ProgramOutcome second = RunBatch();
  EXPECT_EQ(second.code, 0) << second.err << second.out;
  EXPECT_THAT(second.out, ContainsRegex("/out/a +done +1 of 1 +0 +8 +0"));
  EXPECT_THAT(second.out, ContainsRegex("/out/b +done +1 of 1 +0 +8 +0"));
  EXPECT_EQ(CompareRuns(root_ + "/whole", root_ + "/out/b"), "");
}

// Drives of a folder, and what follows segment; what was done stays.
TEST_F(Batch, DoesWhatFollowsForAFolderOfDrives) {
  fs::create_directories(root_ + "/c & <d>");
  ASSERT_TRUE(WriteFileAtomically(root_ + "/c & <d>/1.png", "no picture").ok());
  ASSERT_TRUE(WriteFileAtomically(root_ + "/notes.txt", "mine").ok());
  const std::vector<std::string> arguments = {"batch",
                                              root_,
                                              "--out=" + root_ + "/out",
                                              "--then=refine,masks,render,report",
                                              "--segment_flags=--budget=100 --stride=8",
                                              "--masks_flags=--for=colmap --dilate=2"};
  const ProgramOutcome first = RunProgram(arguments);
  EXPECT_THAT(first, Says(4, "left out: notes.txt"));
  EXPECT_THAT(first.out, ContainsRegex("/out/a +done +5 of 5 +0 +8 +0"));
  EXPECT_THAT(first.out, ContainsRegex("/out/c & <d> +failed +0 of 5 +3 +0 +0"));
  for (const char* file : {"a/report.html", "a/overlay.mp4", "a/masks/000003.png",
                           "a.masks/000003.png.png", "b/report.html"}) {
    EXPECT_TRUE(fs::exists(root_ + "/out/" + file)) << file;
  }
  fs::remove_all(root_ + "/c & <d>");
  fs::remove(root_ + "/out/b/report.html");
  const auto before = fs::last_write_time(root_ + "/out/a/overlay.mp4");
  const ProgramOutcome second = RunProgram(arguments);
  EXPECT_EQ(second.code, 0) << second.err;
  EXPECT_THAT(second.out, ContainsRegex("/out/a +done +5 of 5 +0 +8 +0"));
  EXPECT_THAT(second.out, ContainsRegex("/out/b +done +5 of 5 +0 +8 +0"));
  EXPECT_EQ(fs::last_write_time(root_ + "/out/a/overlay.mp4"), before);
  EXPECT_TRUE(fs::exists(root_ + "/out/b/report.html"));
}

TEST_F(Batch, WhatFailsBehindSegmentIsNamed) {
  ASSERT_TRUE(WriteFileAtomically(root_ + "/drives.toml",
                                  "[defaults]\nbudget = 100\nstride = 8\nthen = \"render\"\n"
                                  "render.loud = true\n"
                                  "[a]\npath = \"a/frames\"\nout = \"out/a\"\n")
                  .ok());
  const ProgramOutcome outcome = RunProgram({"batch", root_ + "/drives.toml"});
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.out,
              ContainsRegex("/out/a +failed +1 of 2 +2 +8 +0 .*render: unknown flag --loud"));
}

TEST_F(Batch, AFlagThatIsOnByDefaultIsTurnedOff) {
  ASSERT_TRUE(WriteFileAtomically(root_ + "/drives.toml",
                                  "[defaults]\nbudget = 100\nstride = 8\nthen = \"render\"\n"
                                  "render.images = true\nrender.video = false\n"
                                  "[a]\npath = \"a/frames\"\nout = \"out/a\"\n")
                  .ok());
  EXPECT_THAT(RunProgram({"batch", root_ + "/drives.toml"}), Succeeds());
  EXPECT_TRUE(fs::exists(root_ + "/out/a/render/000003.png"));
  EXPECT_FALSE(fs::exists(root_ + "/out/a/overlay.mp4"));
}

TEST_F(Batch, ASignalBeforeTheProgramCatchesItIsAnInterruption) {
  const BatchPlan plan = *BatchPlan::Create({{"input", root_ + "/run"}});
  const absl::StatusOr<int> code =
      plan.Run(0, Program("exec sleep 300"), /*to_log=*/true, [] { return true; });
  ASSERT_TRUE(code.ok()) << code.status();
  EXPECT_EQ(*code, 130);
  EXPECT_FALSE(plan.Record(0).has_value());
}

// The kernel reaps the children of a program that was started with SIGCHLD ignored: how they ended
// is not known, and nothing counts as done.
TEST_F(Batch, AStepOfWhichNobodyKnowsHowItEndedIsNotDone) {
  ASSERT_THAT(RunProgram({"segment", root_ + "/a/frames", "--out=" + root_ + "/run", "--budget=100",
                          "--stride=8"}),
              Succeeds());
  ASSERT_THAT(RunProgram({"report", root_ + "/run"}), Succeeds());
  const BatchPlan plan = *BatchPlan::Create({{"input", root_ + "/run", {}, {"report"}}});
  const std::string program = Program("exit 0");
  const auto run = [&] { return plan.Run(1, program, /*to_log=*/true, [] { return false; }); };
  const auto before = signal(SIGCHLD, SIG_IGN);
  const absl::StatusOr<int> lost = run();
  signal(SIGCHLD, before);
  EXPECT_EQ(lost.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_FALSE(plan.IsDone(1));
  EXPECT_THAT(plan.Record(1)->reason, HasSubstr("lost " + program));
  EXPECT_EQ(run().value_or(-1), 0);
  EXPECT_TRUE(plan.IsDone(1));
}

TEST_F(Batch, BadInputsAreOneLineAndStartNothing) {
  const auto expect = [&](std::vector<std::string> arguments, int code, const std::string& part) {
    arguments.insert(arguments.begin(), "batch");
    const ProgramOutcome outcome = RunProgram(arguments);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(part));
    EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
    EXPECT_FALSE(fs::exists(root_ + "/out"));
  };
  const std::string out = "--out=" + root_ + "/out";
  expect({root_}, 2, "--out is missing");
  expect({root_ + "/a/frames", out}, 2, "holds the pictures of one drive");
  expect({root_ + "/no*", out}, 3, "no file matches");
  expect({root_ + "/a/frames/*.png", out}, 2, "has no drive");
  expect({root_, out, "--then=sing"}, 2, "'sing' is none of");
  expect({root_, out, "--segment_flags=stride=3"}, 2, "is no flag");
  expect({root_, root_, out}, 2, "have the same run folder");
  expect({root_, out, "--sbatch=--nice=100"}, 2, "no effect without --engine=slurm");
  ASSERT_TRUE(WriteFileAtomically(root_ + "/list.json", "[]").ok());
  expect({root_ + "/list.json", out}, 2, "is a plan, with drives and flags of its own");
  expect({root_ + "/list.json"}, 2, "is no plan that --plan has written (manifests are TOML)");
}

TEST_F(Batch, FramesThatFailMakeItsExitCodeEachTime) {
  const std::string torn = root_ + "/a/frames/000004.png";
  fs::resize_file(torn, fs::file_size(torn) / 2);
  WriteManifest({Entry("a", "a")});
  for (int repetition = 0; repetition < 2; ++repetition) {
    const ProgramOutcome outcome = RunBatch();
    EXPECT_EQ(outcome.code, 4);
    EXPECT_THAT(outcome.out, ContainsRegex("/out/a +frames failed +1 of 1 +4 +8 +1"));
  }
}

TEST_F(Batch, ABadManifestIsOneLineAndStartsNothing) {
  WriteManifest({Entry("a", "a"), "[b]\npath = 'b'\n"});
  EXPECT_THAT(RunBatch(), EndsWithLine(2, "drives.toml cannot be used: b: no 'out'"));
  EXPECT_FALSE(fs::exists(root_ + "/out"));
  EXPECT_EQ(RunProgram({"batch", root_ + "/none.toml"}).code, 3);
}

TEST_F(Batch, AnInterruptedOneAndAKilledOneGoOn) {
  WriteManifest({Entry("a", "a"), Entry("b", "b")});
  for (const int signal : {SIGTERM, SIGKILL}) {
    fs::remove_all(root_ + "/out");
    fs::remove(root_ + "/batch.err");
    const int code = StartAndSend(signal);
    const std::string table = *ReadFile(root_ + "/batch.out");
    ASSERT_EQ(code, signal == SIGTERM ? 130 : 128 + SIGKILL) << table;
    if (signal == SIGTERM) {
      EXPECT_THAT(table, ContainsRegex("/out/b +not started"));
    }
    EXPECT_FALSE(fs::exists(root_ + "/out/b"));
    ASSERT_TRUE(WaitUntil([&] { return FolderLock::Take(root_ + "/out/a").ok(); }));
    const ProgramOutcome again = RunBatch();
    EXPECT_EQ(again.code, 0) << again.out;
    EXPECT_THAT(again.out, ContainsRegex("/out/a +done +1 of 1 +0 +8 +0"));
    EXPECT_THAT(again.out, ContainsRegex("/out/b +done +1 of 1 +0 +8 +0"));
  }
}

}  // namespace
}  // namespace egosieve::tools
