// A list of drives: what is missing is done, what is there stays, one that fails stops no other.
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <functional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fresh_folder.h"
#include "tests/tools/testing/full_pipe.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tests/tools/testing/run_comparison.h"
#include "tools/batch/drive_job.h"
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

  std::string Entry(const std::string& drive, const std::string& out) const {
    return absl::StrFormat(
        "{\"path\": \"%s/frames\", \"out\": \"out/%s\", \"flags\": {\"budget\": 100, \"stride\": "
        "8, "
        "\"checkpoint_every\": 3}}",
        drive, out);
  }

  void WriteManifest(const std::vector<std::string>& entries) const {
    std::string text = "[";
    for (const std::string& entry : entries) {
      absl::StrAppend(&text, text.size() > 1 ? ",\n" : "", entry);
    }
    ASSERT_TRUE(WriteFileAtomically(root_ + "/drives.json", text + "]").ok());
  }

  // Starts the batch and sends the signal as soon as the first drive has a line. The batch waits
  // where it tells that it has started this drive, so that it starts no other before.
  int StartAndSend(int signal) const {
    FullPipe told(root_ + "/batch.err");
    const pid_t batch =
        StartProgram({"batch", root_ + "/drives.json"}, root_ + "/batch.out", root_ + "/batch.err");
    const std::string log = root_ + "/out/a/frames.jsonl";
    std::error_code error;
    for (int wait = 0; wait < 60000 && (!fs::exists(log, error) || fs::file_size(log, error) == 0);
         ++wait) {
      usleep(1000);  // no longer than a minute: the program may have crashed
    }
    EXPECT_TRUE(fs::exists(log, error));
    kill(batch, signal);
    told.Empty();
    return WaitForProgram(batch);
  }

  ProgramOutcome RunBatch(int jobs = 1) const {
    return RunProgram({"batch", root_ + "/drives.json", absl::StrCat("--jobs=", jobs)});
  }

  static bool WaitUntil(const std::function<bool()>& condition) {
    for (int i = 0; i < 60000 && !condition(); ++i) usleep(1000);
    return condition();
  }

  std::string root_;
};

TEST_F(Batch, DoesWhatIsMissingAndToldWhatFailed) {
  WriteManifest({Entry("a", "a"), Entry("nowhere", "gone"), Entry("b", "b")});
  fs::create_directories(root_ + "/out");
  ASSERT_TRUE(WriteFileAtomically(root_ + "/out/a.log", "mine").ok());
  const ProgramOutcome first = RunBatch(2);
  EXPECT_EQ(first.code, 4) << first.err;
  EXPECT_THAT(first.out, ContainsRegex("/out/a +done +[0-9]+ +8 +0"));
  EXPECT_THAT(first.out, ContainsRegex("/out/gone +failed +[0-9]+ +0 +0 .*nowhere"));
  EXPECT_THAT(first.out, ContainsRegex("/out/b +done +[0-9]+ +8 +0"));
  EXPECT_TRUE(fs::exists(root_ + "/out/egosieve_logs/gone.log"));
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
  EXPECT_THAT(second.out, ContainsRegex("/out/a +was done +[0-9]+ +8 +0"));
  EXPECT_THAT(second.out, ContainsRegex("/out/b +done +[0-9]+ +8 +0"));
  EXPECT_EQ(CompareRuns(root_ + "/whole", root_ + "/out/b"), "");
}

// Drives of a folder, what follows segment, and the page of all; what was done stays.
TEST_F(Batch, DoesWhatFollowsForAFolderOfDrivesAndLinksItAll) {
  fs::create_directories(root_ + "/c & <d>");
  ASSERT_TRUE(WriteFileAtomically(root_ + "/c & <d>/1.png", "no picture").ok());
  ASSERT_TRUE(WriteFileAtomically(root_ + "/notes.txt", "mine").ok());
  const std::vector<std::string> arguments = {"batch",
                                              root_,
                                              "--out=" + root_ + "/out",
                                              "--then=reconstruct,masks,render,report",
                                              "--segment_flags=--budget=100 --stride=8",
                                              "--masks_flags=--for=colmap --dilate=2"};
  const ProgramOutcome first = RunProgram(arguments);
  EXPECT_EQ(first.code, 4) << first.err;
  EXPECT_THAT(first.err, HasSubstr("left out: notes.txt"));
  EXPECT_THAT(first.out, ContainsRegex("/out/a +done +0 +8 +0"));
  EXPECT_THAT(first.out, ContainsRegex("/out/c & <d> +failed +3 +0 +0"));
  for (const char* file : {"a/report.html", "a/overlay.mp4", "a/masks/000003.png",
                           "a.masks/000003.png.png", "b/report.html"}) {
    EXPECT_TRUE(fs::exists(root_ + "/out/" + file)) << file;
  }
  const std::string page = *ReadFile(root_ + "/out/batch.html");
  for (const char* part :
       {"<a href=\"a/report.html\">report</a>", "<a href=\"b/overlay.mp4\">overlay</a>",
        "<a href=\"a.masks\">masks</a>", "<a href=\"egosieve_logs/a.log\">log</a>",
        "<a href=\"egosieve_logs/c%20%26%20%3Cd%3E.log\">log</a>", "c &amp; &lt;d&gt;",
        "3 drives, 2 done, 1 failed", "<td class=\"number\">3</td>"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
  EXPECT_THAT(page, testing::Not(HasSubstr("http-equiv=\"refresh\"")));

  fs::remove_all(root_ + "/c & <d>");
  fs::remove(root_ + "/out/b/report.html");
  const auto before = fs::last_write_time(root_ + "/out/a/overlay.mp4");
  const ProgramOutcome second = RunProgram(arguments);
  EXPECT_EQ(second.code, 0) << second.err;
  EXPECT_THAT(second.out, ContainsRegex("/out/a +was done +0 +8 +0"));
  EXPECT_THAT(second.out, ContainsRegex("/out/b +done +0 +8 +0"));
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
  EXPECT_THAT(outcome.out, ContainsRegex("/out/a +failed +2 +8 +0 .*render: unknown flag --loud"));
}

TEST_F(Batch, AFlagThatIsOnByDefaultIsTurnedOff) {
  ASSERT_TRUE(WriteFileAtomically(root_ + "/drives.toml",
                                  "[defaults]\nbudget = 100\nstride = 8\nthen = \"render\"\n"
                                  "render.images = true\nrender.video = false\n"
                                  "[a]\npath = \"a/frames\"\nout = \"out/a\"\n")
                  .ok());
  const ProgramOutcome outcome = RunProgram({"batch", root_ + "/drives.toml"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(root_ + "/out/a/render/000003.png"));
  EXPECT_FALSE(fs::exists(root_ + "/out/a/overlay.mp4"));
}

// The handler stands for that of the program, which the child has until it executes.
TEST_F(Batch, ASignalRightAfterTheStartEndsADrive) {
  const std::string program = root_ + "/endless";
  ASSERT_TRUE(WriteFileAtomically(program, "#!/bin/sh\nexec sleep 300\n").ok());
  fs::permissions(program, fs::perms::owner_all);
  const auto before = signal(SIGTERM, [](int) {});
  for (int repetition = 0; repetition < 20; ++repetition) {
    absl::StatusOr<DriveJob> job = DriveJob::Start(program, {"input", root_ + "/run", {}, {}});
    ASSERT_TRUE(job.ok()) << job.status();
    job->Interrupt();
    bool has_ended = false;
    for (int i = 0; i < 60000 && !has_ended; ++i) {
      has_ended = job->HasEnded();
      if (!has_ended) usleep(1000);
    }
    ASSERT_TRUE(has_ended) << repetition;
    EXPECT_EQ(job->outcome().state, DriveOutcome::State::kInterrupted);
  }
  signal(SIGTERM, before);
}

// The kernel reaps the children of a program that was started with SIGCHLD ignored: how they ended
// is not known, and nothing counts as done.
TEST_F(Batch, AStepOfWhichNobodyKnowsHowItEndedIsNotDone) {
  const std::string program = root_ + "/program";
  ASSERT_TRUE(WriteFileAtomically(program, "#!/bin/sh\nexit 3\n").ok());
  fs::permissions(program, fs::perms::owner_all);
  const BatchEntry entry = {"input", root_ + "/run", {}, {{"report", {}}}};
  const auto before = signal(SIGCHLD, SIG_IGN);
  absl::StatusOr<DriveJob> job = DriveJob::Start(program, entry);
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_TRUE(WaitUntil([&] { return job->HasEnded(); }));
  signal(SIGCHLD, before);
  EXPECT_EQ(job->outcome().state, DriveOutcome::State::kFailed);
  EXPECT_THAT(job->outcome().reason, HasSubstr("cannot tell how segment ended"));
  EXPECT_FALSE(fs::exists(TaskNotesPath(entry)));
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
  expect({root_, root_, out}, 2, "is that of entry");
  for (const std::string flag :
       {"--scene_cuts", "--cpus=1", "--sbatch=--nice=100", "--measured_frames=9", "--dry_run"}) {
    expect({root_, out, flag}, 2, "--status: " + flag.substr(0, flag.find('=')) + ";");
  }
  ASSERT_TRUE(WriteFileAtomically(root_ + "/mine.html", "mine").ok());
  expect({root_, out, "--index=" + root_ + "/mine.html"}, 2, "is no page of a batch");
  EXPECT_EQ(*ReadFile(root_ + "/mine.html"), "mine");
}

TEST_F(Batch, FramesThatFailMakeItsExitCodeEachTime) {
  const std::string torn = root_ + "/a/frames/000004.png";
  fs::resize_file(torn, fs::file_size(torn) / 2);
  WriteManifest({Entry("a", "a")});
  for (int repetition = 0; repetition < 2; ++repetition) {
    const ProgramOutcome outcome = RunBatch();
    EXPECT_EQ(outcome.code, 4);
    EXPECT_THAT(outcome.out, ContainsRegex("/out/a +frames failed +[0-9]+ +7 +1"));
  }
}

TEST_F(Batch, ABadManifestIsOneLineAndStartsNothing) {
  WriteManifest({Entry("a", "a"), "{\"path\": \"b\"}"});
  const ProgramOutcome outcome = RunBatch();
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("drives.json cannot be used: entry 2: no 'out'"));
  EXPECT_EQ(CountLines(outcome.err), 1);
  EXPECT_FALSE(fs::exists(root_ + "/out"));
  EXPECT_EQ(RunProgram({"batch", root_ + "/none.json"}).code, 3);
}

TEST_F(Batch, AnInterruptedOneGoesOn) {
  WriteManifest({Entry("a", "a"), Entry("b", "b")});
  const int code = StartAndSend(SIGTERM);
  const std::string table = *ReadFile(root_ + "/batch.out");
  ASSERT_EQ(code, 130) << table;
  EXPECT_THAT(table, ContainsRegex("/out/b +not started"));
  const ProgramOutcome again = RunBatch();
  EXPECT_EQ(again.code, 0) << again.out;
  EXPECT_THAT(again.out, ContainsRegex("/out/a +(was )?done +[0-9]+ +8 +0"));
  EXPECT_THAT(again.out, ContainsRegex("/out/b +done +[0-9]+ +8 +0"));
}

TEST_F(Batch, AKilledOneGoesOn) {
  WriteManifest({Entry("a", "a"), Entry("b", "b")});
  const int code = StartAndSend(SIGKILL);
  ASSERT_EQ(code, 128 + SIGKILL);
  EXPECT_FALSE(fs::exists(root_ + "/out/b"));
  ASSERT_TRUE(WaitUntil([&] { return FolderLock::Take(root_ + "/out/a").ok(); }));
  const ProgramOutcome again = RunBatch();
  EXPECT_EQ(again.code, 0) << again.out;
  EXPECT_THAT(again.out, ContainsRegex("/out/a +(was )?done +[0-9]+ +8 +0"));
  EXPECT_THAT(again.out, ContainsRegex("/out/b +done +[0-9]+ +8 +0"));
}

// Otherwise a drive would go on writing where the next batch begins. Its program is one that would
// never end by itself.
TEST_F(Batch, AKilledOneEndsItsDrives) {
  const std::string program = root_ + "/endless", pid_path = root_ + "/pid";
  ASSERT_TRUE(WriteFileAtomically(program, "#!/bin/sh\necho $$ > " + pid_path + ".tmp\nmv " +
                                               pid_path + ".tmp " + pid_path +
                                               "\nexec sleep 100000\n")
                  .ok());
  fs::permissions(program, fs::perms::owner_all);
  const pid_t batch = fork();
  if (batch == 0) {
    const absl::StatusOr<DriveJob> job =
        DriveJob::Start(program, {"input", root_ + "/run", {}, {}});
    while (job.ok()) pause();
    _exit(1);
  }
  ASSERT_TRUE(WaitUntil([&] { return fs::exists(pid_path); }));
  const pid_t drive = static_cast<pid_t>(std::stoi(*ReadFile(pid_path)));
  EXPECT_EQ(kill(drive, 0), 0);
  kill(batch, SIGKILL);
  WaitForProgram(batch);
  // Gone, or dead and waiting for its new parent to notice.
  EXPECT_TRUE(WaitUntil([&] {
    const absl::StatusOr<std::string> stat = ReadFile(absl::StrCat("/proc/", drive, "/stat"));
    return !stat.ok() || stat->find(") Z ") != std::string::npos;
  }));
  kill(drive, SIGKILL);
}

}  // namespace
}  // namespace egosieve::tools
