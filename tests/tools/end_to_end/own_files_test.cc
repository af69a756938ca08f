// What a run reads is not what it removes, and what it wrote is there, or made again.
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "absl/strings/str_format.h"
#include "tests/testing/status.h"
#include "tests/tools/testing/fresh_folder.h"
#include "tests/tools/testing/full_pipe.h"
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
  EXPECT_THAT(refine, EndsWithLine(3, "the map of frame 6"));
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
    EXPECT_THAT(SegmentFrames({"--resume"}), EndsWithLine(4, "1 frames could not be read")) << call;
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
