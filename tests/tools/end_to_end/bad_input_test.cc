// What a user can get wrong: each gives one line that says what is wrong and what to do, the right
// exit code, and leaves nothing behind that was not there.
#include <signal.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tests/tools/testing/run_comparison.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class BadInput : public testing::Test {
 protected:
  BadInput() : root_(FreshFolder()), input_(root_ + "/frames"), out_(root_ + "/out") {
    fs::create_directories(input_);
  }

  std::string Frame(int index) const { return input_ + absl::StrFormat("/%06d.png", index); }
  void WriteFrames(int frames) { WritePatchDrive(root_, SmallPatchDrive(frames)); }

  ProgramOutcome Segment(const std::string& input, std::vector<std::string> more = {}) const {
    return RunProgram(std::vector<std::string>{"segment", input, "--out=" + out_, "--progress=none",
                                               "--budget=200"} +
                      more);
  }

  // One line, the exit code, what it must say; and no run folder.
  void ExpectRefused(const ProgramOutcome& outcome, int code, const std::string& what) const {
    ExpectErrorLine(outcome, code, what);
    EXPECT_EQ(outcome.out, "");
    EXPECT_FALSE(fs::exists(out_ + "/run.json"));
  }

  // A run with a map for each of `frames` frames.
  std::vector<FrameLine> ExpectAnswered(int frames) const {
    const absl::StatusOr<RunFolder> folder = RunFolder::Open(out_);
    if (!folder.ok()) {
      ADD_FAILURE() << folder.status();
      return {};
    }
    const std::vector<FrameLine> lines = *folder->ReadLines();
    const RunDescription description = *folder->ReadDescription();
    EXPECT_EQ(description.ended, "done");
    EXPECT_EQ(lines.size(), static_cast<size_t>(frames));
    for (const FrameLine& line : lines) {
      EXPECT_TRUE(folder->ReadGridMaps(line, description, true).ok()) << line.index;
    }
    return lines;
  }

  std::string root_, input_, out_;
};

TEST_F(BadInput, WhatIsNoDrive) {
  std::ofstream(root_ + "/text.mp4") << "This is not a video.\n";
  std::ofstream(root_ + "/empty.mp4");
  for (const char* name : {"no.mp4", "text.mp4", "empty.mp4", "frames", "frames/*.jpg"}) {
    ExpectRefused(Segment(root_ + "/" + name), 3, name);
  }
  for (int i = 0; i < 3; ++i) std::ofstream(Frame(i)) << "not a picture";
  ExpectRefused(Segment(input_), 3, "frames");
}

// Opening one would wait for somebody to write into it.
TEST_F(BadInput, APipe) {
  for (const char* name : {"/pipe.mp4", "/pipe.png", "/pipe.json"}) {
    const std::string pipe = root_ + name;
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    if (pipe.ends_with(".json")) {
      const ProgramOutcome outcome = RunProgram({"batch", pipe});
      EXPECT_NE(outcome.code, 0);
      EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
      EXPECT_THAT(outcome.err, HasSubstr(pipe));
    } else {
      ExpectRefused(Segment(pipe), 3, "neither a file nor a folder");
    }
  }
}

TEST_F(BadInput, APipeWhereARunHasItsNumbers) {
  const std::string drive = root_ + "/drive";
  ASSERT_THAT(RunProgram({"synthesize", "--scenario=street", "--frames=3", "--width=96",
                          "--height=64", "--out=" + drive, "--progress=none"}),
              Succeeds());
  ASSERT_THAT(Segment(drive + "/frames"), Succeeds());
  ASSERT_THAT(RunProgram({"refine", out_, "--progress=none"}), Succeeds());
  const std::string pipe = out_ + "/ids/000001.png";
  fs::remove(pipe);
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"render", out_, "--images", "--no_video", "--progress=none"},
        {"report", out_, "--progress=none"}}) {
    const ProgramOutcome outcome = RunProgram(command);
    EXPECT_EQ(outcome.code, command[0] == "report" ? 0 : 2) << command[0];
    EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(pipe + " is not a regular file")) << command[0];
  }
}

TEST_F(BadInput, AListThatDoesNotHoldWhatItMust) {
  WriteFrames(3);
  const std::string list = root_ + "/list.txt", times = root_ + "/times.txt";
  const auto expect = [&](const char* text, const char* what) {
    std::ofstream(list) << text;
    ExpectRefused(Segment(list), 3, what);
    EXPECT_FALSE(fs::exists(out_)) << what;
  };
  expect("# nothing\n", "names no picture");
  expect("frames/000000.png\nframes/000009.png\n", "line 2: no such file");
  expect("0.2 frames/000000.png\n0.1 frames/000001.png\n", "line 2: the time 0.1 does not come");
  std::ofstream(times) << "0.0\n0.1\n";
  ExpectRefused(Segment(input_, {"--times=" + times}), 3, "has 2 times for 3 pictures");
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(BadInput, AFolderWithOneFrame) {
  WriteFrames(1);
  const ProgramOutcome outcome = Segment(input_);
  EXPECT_THAT(outcome, EndsWithLine(4, "every map is the prior"));
  EXPECT_THAT(outcome.err, HasSubstr("two at least"));
  ExpectAnswered(1);
}

TEST_F(BadInput, ImagesOfDifferentSizes) {
  WriteFrames(4);
  cv::Mat image = cv::imread(Frame(2));
  cv::resize(image, image, cv::Size(120, 80));
  cv::imwrite(Frame(2), image);
  const ProgramOutcome outcome = Segment(input_);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("1 of 4 frames are of another size"));
  const std::vector<FrameLine> lines = ExpectAnswered(4);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[2].width_pixels, 120);
  EXPECT_FALSE(lines[2].reason.empty());
}

TEST_F(BadInput, ABrokenImageAmongGoodOnes) {
  WriteFrames(5);
  fs::resize_file(Frame(2), fs::file_size(Frame(2)) / 2);
  const ProgramOutcome outcome = Segment(input_);
  EXPECT_THAT(outcome, EndsWithLine(4, "000002.png"));
  const std::vector<FrameLine> lines = *RunFolder::Open(out_)->ReadLines();
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[2].outcome, FrameLine::Outcome::kFailed);
  EXPECT_EQ(lines[4].outcome, FrameLine::Outcome::kLearnt);
  const RunFolder folder = *RunFolder::Open(out_);
  EXPECT_TRUE(*ReadFile(folder.FrameFile("grid", 2, ".prob.png")) ==
              *ReadFile(folder.FrameFile("grid", 1, ".prob.png")));
  EXPECT_TRUE(folder.ReadGridMaps(lines[2], *folder.ReadDescription(), true).ok());
  // What follows copes: a frame without its picture has a map, and no mask.
  EXPECT_EQ(RunProgram({"refine", out_, "--progress=none"}).code, 4);
  EXPECT_EQ(RunProgram({"render", out_, "--progress=none", "--images", "--no_video"}).code, 4);
  EXPECT_THAT(RunProgram({"report", out_, "--progress=none"}), Succeeds());
}

// A picture that is damaged inside is answered, whether its decoder refuses it or delivers rubbish.
TEST_F(BadInput, CorruptJpegsAndAMissingFrame) {
  constexpr int kFrames = 9;
  const auto path = [&](int index) { return input_ + absl::StrFormat("/%06d.jpg", index); };
  for (int i = 0; i < kFrames; ++i) {
    cv::imwrite(path(i), PatchFrame(SmallPatchDrive(kFrames), i), {cv::IMWRITE_JPEG_QUALITY, 92});
  }
  std::string bytes = *ReadFile(path(3));
  for (size_t i = bytes.size() / 2; i < bytes.size() / 2 + 60; ++i)
    bytes[i] = static_cast<char>(i * 37);
  std::ofstream(path(3), std::ios::binary) << bytes;
  fs::resize_file(path(5), fs::file_size(path(5)) / 2);
  fs::remove(path(7));
  const ProgramOutcome outcome = Segment(input_);
  EXPECT_EQ(outcome.code, 4);
  EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
  const std::vector<FrameLine> lines = ExpectAnswered(kFrames - 1);
  ASSERT_EQ(lines.size(), static_cast<size_t>(kFrames - 1));
  EXPECT_EQ(lines[5].outcome, FrameLine::Outcome::kFailed);
  for (const FrameLine& line : lines) {
    EXPECT_EQ(line.reason.empty(), line.outcome == FrameLine::Outcome::kLearnt) << line.index;
  }
  EXPECT_EQ(lines.back().outcome, FrameLine::Outcome::kLearnt);
}

TEST_F(BadInput, ATruncatedVideo) {
  const std::string path = root_ + "/drive.avi";
  WritePatchVideo(path, SmallPatchDrive(12), 12);
  const uintmax_t size = fs::file_size(path);
  fs::resize_file(path, size / 2);
  EXPECT_THAT(Segment(path), EndsWithLine(4, "drive.avi"));
  EXPECT_GE(RunFolder::Open(out_)->ReadLines()->size(), 3u);

  fs::remove_all(out_);
  fs::resize_file(path, 100);  // not even the header is whole
  ExpectRefused(Segment(path), 3, "drive.avi");
}

TEST_F(BadInput, AnOutputFolderThatHoldsSomething) {
  WriteFrames(2);
  fs::create_directories(out_);
  std::ofstream(out_ + "/notes.txt") << "mine";
  ExpectRefused(Segment(input_), 2, "--out");
  ExpectRefused(Segment(input_, {"--overwrite"}), 2, "holds no run");
  EXPECT_TRUE(fs::exists(out_ + "/notes.txt"));

  fs::remove_all(out_);
  EXPECT_THAT(Segment(input_), Succeeds());
  EXPECT_THAT(Segment(input_), Says(2, "--overwrite"));
  EXPECT_THAT(Segment(input_, {"--overwrite"}), Succeeds());

  fs::remove_all(out_);
  std::ofstream(out_) << "a file";
  ExpectRefused(Segment(input_), 2, "is a file");
}

// Its maps would be pictures of the input when that is read again.
TEST_F(BadInput, AnOutputFolderInsideTheInput) {
  WriteFrames(2);
  fs::create_directory_symlink(input_, root_ + "/link");
  for (const std::string& inside : {input_, input_ + "/run", root_ + "/link/run"}) {
    out_ = inside;
    for (const char* flag : {"--resume", "--overwrite"}) {
      ExpectRefused(Segment(input_, {flag}), 2, "lies in what is read");
    }
    EXPECT_FALSE(fs::exists(input_ + "/run"));
  }
}

TEST_F(BadInput, AnOutputFolderThatCannotBeWritten) {
  WriteFrames(2);
  out_ = "/proc/egosieve/out";
  ExpectRefused(Segment(input_), 1, "cannot write /proc/egosieve/out");
}

TEST_F(BadInput, FlagsThatAreNone) {
  WriteFrames(2);
  ExpectRefused(Segment(input_, {"--strid=4"}), 2, "unknown flag --strid");
  ExpectRefused(Segment(input_, {"--frobnicate"}), 2, "--frobnicate");
  ExpectRefused(Segment(input_, {"--stride=0"}), 2, "--stride: 0 is not from 1 to 1000");
  ExpectRefused(Segment(input_, {"--stride=five"}), 2, "--stride");
  ExpectRefused(Segment(input_, {"--set=window=4"}), 2, "window");
  ExpectRefused(Segment(input_, {"--profile=best"}), 2, "'best' is none of default, paper");
  ExpectRefused(Segment(input_, {"--from=5", "--to=3"}), 2, "--to=3");
  ExpectRefused(Segment(input_, {"--from=99"}), 3, "has 2 frames");
  ExpectRefused(Segment(input_, {"--to=-5"}), 2, "--to: -5 is less than -1");
  ExpectRefused(Segment(input_, {"--seed=-3"}), 2, "--seed: -3 is less than 0");
  ExpectRefused(Segment(input_, {"--device=abacus"}), 2, "abacus");
  ExpectRefused(Segment(input_, {"--set=covariance=matern5"}), 2,
                "functions are arcsine, constant");
  ExpectRefused(Segment(input_, {"--set=covariance=white + constant"}), 2,
                "has no scale for each input");
  ExpectRefused(Segment(input_, {"--location_prior=0"}), 2, "unknown flag --location_prior");
  ExpectRefused(Segment(input_, {"--set", "location_prior=2"}), 2,
                "--set location_prior: 2 is not from 0 to 1");
  ExpectRefused(Segment(input_, {"--set", "location_prio=0"}), 2,
                "unknown flag --set location_prio");
  ExpectRefused(RunProgram({"segment", input_, "--outt=3"}), 2, "unknown flag --outt");
}

TEST_F(BadInput, FoldersThatAreNoRuns) {
  WriteFrames(2);
  for (const char* command : {"refine", "render", "report"}) {
    ExpectRefused(RunProgram({command, input_}), 3, "run.json");
    ExpectRefused(RunProgram({command, "/nowhere"}), 3, "/nowhere");
  }
}

// What a run reads is not what it removes, and what it wrote is there, or made again.

class OwnFiles : public testing::Test {
 protected:
  static constexpr int kFrames = 10;

  OwnFiles() : root_(FreshFolder()), run_(root_ + "/run") {
    WritePatchDrive(root_, SmallPatchDrive(kFrames));
  }

  ProgramOutcome Segment(const std::string& input, std::vector<std::string> more = {}) const {
    return RunProgram(std::vector<std::string>{"segment", input, "--out=" + run_, "--budget=150",
                                               "--stride=8", "--progress=none",
                                               "--checkpoint_every=4"} +
                      more);
  }
  ProgramOutcome SegmentFrames(std::vector<std::string> more = {}) const {
    return Segment(root_ + "/frames", std::move(more));
  }

  void Keep() const { fs::copy(run_, root_ + "/kept", fs::copy_options::recursive); }
  std::string Changes() const { return CompareRuns(root_ + "/kept", run_); }

  std::string root_, run_;
};

TEST_F(OwnFiles, ARunIsNotReplacedByWhatIsReadFromIt) {
  ASSERT_THAT(SegmentFrames(), Succeeds());
  ASSERT_THAT(RunProgram({"render", run_, "--images", "--no_video", "--progress=none"}),
              Succeeds());
  fs::create_symlink(run_ + "/render", root_ + "/link");
  fs::create_directories(root_ + "/links");
  for (int i = 0; i < kFrames; ++i) {
    const std::string name = absl::StrFormat("/%06d.png", i);
    fs::create_symlink(run_ + "/render" + name, root_ + "/links" + name);
  }
  Keep();
  for (const std::string& input : {run_ + "/render", root_ + "/link", root_ + "/links",
                                   run_ + "/render/*.png", run_ + "/../run/render"}) {
    EXPECT_THAT(Segment(input, {"--overwrite"}), EndsWithLine(2, "is or holds what is read"))
        << input;
    ASSERT_EQ(Changes(), "") << input;
  }
}

TEST_F(OwnFiles, ARunThatIsBeingWrittenIsNotReplaced) {
  ASSERT_THAT(SegmentFrames(), Succeeds());
  Keep();
  {
    const FolderLock writer = Value(FolderLock::Take(run_));
    EXPECT_EQ(SegmentFrames({"--overwrite"}).code, 2);
    EXPECT_EQ(Changes(), "");
  }
  EXPECT_THAT(SegmentFrames({"--overwrite"}), Succeeds());
}

TEST_F(OwnFiles, MissingAndEmptyMapsAreMadeAgain) {
  ASSERT_THAT(SegmentFrames(), Succeeds());
  Keep();
  fs::remove(run_ + "/grid/000006.prob.png");
  fs::resize_file(run_ + "/grid/000008.std.png", 0);
  const ProgramOutcome refine = RunProgram({"refine", run_, "--progress=none"});
  EXPECT_THAT(refine, Says(3, "the map of frame 6"));
  EXPECT_THAT(refine.err, HasSubstr("egosieve segment --resume --out=" + run_));
  EXPECT_FALSE(fs::exists(run_ + "/full"));
  EXPECT_THAT(SegmentFrames({"--resume"}), Succeeds());
  EXPECT_EQ(Changes(), "");
  EXPECT_THAT(SegmentFrames({"--resume"}).out, HasSubstr("holds the whole run already"));
}

TEST_F(OwnFiles, TheSecondCallHasTheExitCodeOfTheFirst) {
  const std::string torn = root_ + "/frames/000004.png";
  fs::resize_file(torn, fs::file_size(torn) / 2);
  for (int call = 0; call < 2; ++call) {
    EXPECT_THAT(SegmentFrames({"--resume"}), Says(4, "1 frames could not be read")) << call;
  }
}

// From before anything is written to the end, a signal is a request to end between two frames. What
// comes before the program's first instruction, while the system loads its libraries, is not.
TEST_F(OwnFiles, AnEarlySignalIsAnInterruption) {
  constexpr int kManyFrames = 30;  // more than are under way at once
  WritePatchDrive(root_, SmallPatchDrive(kManyFrames));
  for (const int milliseconds : {0, 20, 60, 120, 300}) {
    fs::remove_all(run_);
    fs::remove(root_ + "/told");
    // It waits behind the first frame, where it tells its progress, so that it cannot end before.
    FullPipe told(root_ + "/told");
    const pid_t process =
        StartProgram({"segment", root_ + "/frames", "--out=" + run_, "--budget=150", "--stride=8",
                      "--no_first_pass", "--progress=json"},
                     root_ + "/out.txt", root_ + "/told");
    bool was_written = false;
    WaitUntil([&] {
      was_written = was_written || fs::exists(run_);
      return Catches(process, SIGTERM);
    });
    EXPECT_FALSE(was_written) << "something was written before signals were caught";
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    kill(process, SIGTERM);
    told.Empty();
    EXPECT_EQ(WaitForProgram(process), 130) << told.Empty();
    // In the first pass over the drive there is no run yet.
    if (fs::exists(run_ + "/run.json")) {
      EXPECT_EQ(RunFolder::Open(run_)->ReadDescription()->ended, "interrupted");
    }
    EXPECT_THAT(RunProgram({"segment", root_ + "/frames", "--out=" + run_, "--budget=150",
                            "--stride=8", "--no_first_pass", "--progress=none", "--resume"}),
                Succeeds());
    EXPECT_EQ(RunFolder::Open(run_)->ReadLines()->size(), static_cast<size_t>(kManyFrames));
  }
}

}  // namespace
}  // namespace egosieve::tools
