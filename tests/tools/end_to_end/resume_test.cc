// A run that is killed, at any moment and any number of times, and resumed gives the bytes of one
// that was not.
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <set>
#include <thread>

#include "absl/strings/str_format.h"
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

class Resume : public testing::Test {
 protected:
  static constexpr int kFrames = 18, kCut = 10;

  // Compiled kernels lie where no other test writes, and are there before anything is limited.
  static void SetUpTestSuite() {
    const std::string cache = std::string(std::getenv("TEST_TMPDIR")) + "/cache";
    setenv("EGOSIEVE_CACHE_DIR", cache.c_str(), 1);
    setenv("POCL_CACHE_DIR", (cache + "/pocl").c_str(), 1);
    fs::create_directories(cache + "/pocl");
  }

  Resume() : root_(FreshFolder()), whole_(root_ + "/whole"), run_(root_ + "/run") {
    WritePatchDrive(root_, SmallPatchDrive(kFrames));
    for (int frame = kCut; frame < kFrames; ++frame) {  // another shot
      const std::string path = root_ + absl::StrFormat("/frames/%06d.png", frame);
      cv::Mat picture = cv::imread(path);
      cv::flip(picture, picture, 0);
      cv::imwrite(path, picture);
    }
    // A frame that cannot be read, just before a checkpoint.
    const std::string torn = root_ + absl::StrFormat("/frames/%06d.png", 7);
    fs::resize_file(torn, fs::file_size(torn) / 2);
    // The first run of a machine compiles kernels: the second is as long as those to be killed.
    EXPECT_EQ(RunProgram(Arguments(whole_)).code, 4);
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(RunProgram(Arguments(whole_, {"--overwrite"})).code, 4);
    whole_duration_ = std::chrono::steady_clock::now() - start;
  }

  std::vector<std::string> Arguments(const std::string& out,
                                     std::vector<std::string> more = {}) const {
    return std::vector<std::string>{
               "segment",    root_ + "/frames", "--out=" + out,        "--budget=150",
               "--stride=8", "--progress=none", "--checkpoint_every=4"} +
           more;
  }

  // Starts or goes on, and sends the signal after a while. Returns the exit code.
  int ResumeAndSend(int signal, std::chrono::duration<double> after) {
    const pid_t process =
        StartProgram(Arguments(run_, {"--resume"}), root_ + "/out.txt", root_ + "/err.txt");
    std::this_thread::sleep_for(after);
    kill(process, signal);
    return WaitForProgram(process);
  }

  // A run from the beginning that gets the signal once its log has `lines`. Returns the exit code;
  // where the run was over before, which `done` tells, it is tried again.
  int StartAndSend(int signal, const std::vector<std::string>& arguments, int lines, int done) {
    int code = done;
    for (int attempt = 0; attempt < 5 && code == done; ++attempt) {
      fs::remove_all(run_);
      const pid_t process = StartProgram(arguments, root_ + "/out.txt", root_ + "/err.txt");
      WaitForLines(lines);
      kill(process, signal);
      code = WaitForProgram(process);
    }
    return code;
  }

  // A copy of the whole run that tells that it ended so.
  void StartFromWhole(const std::string& ended = "running") {
    fs::remove_all(run_);
    fs::copy(whole_, run_, fs::copy_options::recursive);
    RunDescription description = *RunFolder::Open(run_)->ReadDescription();
    description.ended = ended;
    ASSERT_TRUE(RunFolder::Open(run_)->WriteDescription(description).ok());
  }

  // The whole run as a kill leaves it once the frames before `frame` have their lines.
  void LeaveWholeAsKilledBefore(int64_t frame) {
    StartFromWhole();
    ASSERT_TRUE(LineLog::OpenTruncated(run_ + "/frames.jsonl", frame).ok());
    fs::remove(run_ + absl::StrFormat("/steps/%06d.npz", frame));
    fs::remove(run_ + absl::StrFormat("/grid/%06d.prob.png", frame));
  }

  static std::vector<std::string> CheckpointsIn(const std::string& run) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(run + "/model")) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  // Until the log has some lines; not for ever, where the program has crashed.
  void WaitForLines(int count) const {
    const std::string log = run_ + "/frames.jsonl";
    WaitUntil([&] {
      const std::string text = ReadFile(log).value_or("");
      return std::count(text.begin(), text.end(), '\n') >= count;
    });
  }

  std::string root_, whole_, run_;
  std::chrono::duration<double> whole_duration_;
};

TEST_F(Resume, TheDriveHasTwoShots) {
  EXPECT_THAT(Value(ReadShots(whole_)).first_frames, testing::ElementsAre(0, kCut));
  EXPECT_TRUE(fs::exists(whole_ + "/shots/000010.camera.json"));
}

TEST_F(Resume, AfterKillsAtRandomMomentsTheBytesAreThoseOfAnUninterruptedRun) {
  std::mt19937_64 random(20);
  int kills = 0, completions = 0;
  while (kills < 20) {
    const int signal = kills % 4 == 3 ? SIGTERM : SIGKILL;
    const int code = ResumeAndSend(signal, whole_duration_ * (random() % 1000) / 1000.0);
    if (code == 128 + SIGKILL || code == 128 + SIGTERM || code == 130) {
      ++kills;
    } else {
      ASSERT_TRUE(code == 4 || code == 0) << code << ": " << *ReadFile(root_ + "/err.txt");
      ASSERT_EQ(CompareRuns(whole_, run_), "") << "after " << kills << " kills";
      fs::remove_all(run_);
      ++completions;
      ASSERT_LT(completions, 500) << "runs end before their signal";
    }
  }
  const int code = RunProgram(Arguments(run_, {"--resume"})).code;
  EXPECT_TRUE(code == 4 || code == 0) << code;
  EXPECT_EQ(CompareRuns(whole_, run_), "");
}

// Where the kill hits between two writes: every state that a folder can be left in, by hand.
TEST_F(Resume, FromEveryStateThatAKillCanLeave) {
  const auto cut_log = [&](int64_t lines, const std::string& rest) {
    const std::string log = run_ + "/frames.jsonl";
    ASSERT_TRUE(LineLog::OpenTruncated(log, lines).ok());
    ASSERT_TRUE(WriteFileAtomically(log, *ReadFile(log) + rest).ok());
  };
  const auto resume = [&] {
    const int code = RunProgram(Arguments(run_, {"--resume"})).code;
    EXPECT_TRUE(code == 4 || code == 0) << code;
    return CompareRuns(whole_, run_);
  };

  StartFromWhole();  // killed before the end was written
  EXPECT_EQ(resume(), "");
  StartFromWhole();  // in the middle of a line
  cut_log(14, "{\"index\":14,\"time_sec");
  EXPECT_EQ(resume(), "");
  StartFromWhole();  // between a frame's line and its checkpoint (15)
  cut_log(16, "");
  fs::remove(run_ + "/model/000015.npz");
  EXPECT_EQ(resume(), "");
  StartFromWhole();  // a damaged checkpoint, the one before is whole
  fs::resize_file(run_ + "/model/000015.npz", 100);
  EXPECT_EQ(resume(), "");
  StartFromWhole();  // before the first line
  fs::remove_all(run_ + "/model");
  fs::remove(run_ + "/frames.jsonl");
  EXPECT_EQ(resume(), "");
}

// Killed between the writing of a checkpoint and the removal of the oldest, and in the middle of a
// writing; also where nothing is left to do.
TEST_F(Resume, RemovesTheCheckpointThatAKillLeft) {
  const std::string begun = root_ + "/begun";
  ASSERT_EQ(RunProgram(Arguments(begun, {"--max_frames=10"})).code, 4);
  const auto leave = [&](const std::string& ended) {
    StartFromWhole(ended);
    fs::copy(begun + "/model/000007.npz", run_ + "/model/000007.npz");
    ASSERT_TRUE(fs::exists(run_ + "/model/000011.npz") && fs::exists(run_ + "/model/000015.npz"));
    std::ofstream(run_ + "/model/000015.npz.aBcdEF.egosieve.tmp") << "half";
  };
  for (const char* ended : {"running", "done"}) {
    leave(ended);
    EXPECT_EQ(RunProgram(Arguments(run_, {"--resume"})).code, 4);
    EXPECT_EQ(CompareRuns(whole_, run_), "") << ended;
  }
  // Those after the place where the run goes on are no reason to remove the newest before it.
  leave("running");
  fs::remove(run_ + "/grid/000010.prob.png");
  EXPECT_EQ(RunProgram(Arguments(run_, {"--resume", "--max_frames=11"})).code, 4);
  EXPECT_EQ(CheckpointsIn(run_), (std::vector<std::string>{"000007.npz"}));
  EXPECT_EQ(RunProgram(Arguments(run_, {"--resume"})).code, 4);
  EXPECT_EQ(CompareRuns(whole_, run_), "");
}

// Asked to end once the first frame has its line.
TEST_F(Resume, AnInterruptionEndsBetweenFramesAndSaysSo) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const int code = StartAndSend(signal, Arguments(run_), 1, 4);
    ASSERT_EQ(code, 130) << *ReadFile(root_ + "/err.txt");
    const RunFolder folder = *RunFolder::Open(run_);
    const RunDescription description = *folder.ReadDescription();
    EXPECT_EQ(description.ended, "interrupted");
    const std::vector<FrameLine> lines = *folder.ReadLines();
    for (const FrameLine& line : lines) {
      EXPECT_TRUE(folder.ReadGridMaps(line, description, true).ok()) << line.index;
    }
    EXPECT_THAT(*ReadFile(root_ + "/err.txt"), HasSubstr("--resume goes on"));
    const int resumed = RunProgram(Arguments(run_, {"--resume"})).code;
    EXPECT_TRUE(resumed == 4 || resumed == 0) << resumed;
    EXPECT_EQ(CompareRuns(whole_, run_), "");
  }
}

// Another profile: likewise.
TEST_F(Resume, OfAnotherProfile) {
  ASSERT_EQ(RunProgram(Arguments(whole_, {"--profile=fast", "--overwrite"})).code, 4);
  LeaveWholeAsKilledBefore(14);           // the checkpoint before it is that after frame 11
  for (int time = 0; time < 2; ++time) {  // then nothing is left to do
    EXPECT_EQ(RunProgram(Arguments(run_, {"--profile=fast", "--resume"})).code, 4);
    EXPECT_EQ(CompareRuns(whole_, run_), "");
  }
}

// On a drive that is three times as fast from the ninth frame on, so that the gap changes: what chose
// it, and the pictures that it reaches back to, come back with the checkpoint.
TEST_F(Resume, WithTheFrameGapThatItChose) {
  fs::remove_all(root_ + "/frames");
  ASSERT_THAT(
      RunProgram({"synthesize", "--scenario=street", "--frames=36", "--width=192", "--height=108",
                  "--frames_per_second=30", "--out=" + root_ + "/street", "--progress=none"}),
      Succeeds());
  fs::create_directory(root_ + "/frames");
  for (int k = 0; k < kFrames; ++k) {
    const int drawn = k < 9 ? k : 9 + 3 * (k - 9);
    fs::rename(absl::StrFormat("%s/street/frames/%06d.png", root_, drawn),
               absl::StrFormat("%s/frames/%06d.png", root_, k));
  }
  ASSERT_THAT(
      RunProgram(Arguments(whole_, {"--set=frame_gap=auto", "--no_first_pass", "--overwrite"})),
      Succeeds());
  const std::vector<FrameLine> lines = *RunFolder::Open(whole_)->ReadLines();
  ASSERT_EQ(lines.size(), static_cast<size_t>(kFrames));
  std::set<int64_t> late_gaps;
  for (size_t i = 6; i < lines.size(); ++i) late_gaps.insert(lines[i].frame_gap);
  ASSERT_GE(late_gaps.size(), 2u) << "the gap stays, and shows nothing";
  const auto resume = [&] {
    EXPECT_THAT(
        RunProgram(Arguments(run_, {"--set=frame_gap=auto", "--no_first_pass", "--resume"})),
        Succeeds());
    return CompareRuns(whole_, run_);
  };
  for (const int frame : {8, 12, 17}) {
    LeaveWholeAsKilledBefore(frame);
    EXPECT_EQ(resume(), "") << "cut before frame " << frame;
  }
  for (const int signal : {SIGKILL, SIGTERM}) {
    const int code =
        StartAndSend(signal, Arguments(run_, {"--set=frame_gap=auto", "--no_first_pass"}), 9, 0);
    EXPECT_EQ(code, signal == SIGKILL ? 128 + SIGKILL : 130);
    EXPECT_EQ(resume(), "") << "signal " << signal;
  }
}

TEST_F(Resume, ThreadsDoNotShowInTheBytes) {
  for (const char* profile : {"--profile=default", "--profile=fast"}) {
    fs::remove_all(run_);
    EXPECT_EQ(RunProgram(Arguments(whole_, {"--overwrite", "--threads=1", profile})).code, 4);
    EXPECT_EQ(RunProgram(Arguments(run_, {"--threads=4", profile})).code, 4);
    EXPECT_EQ(CompareRuns(whole_, run_), "") << profile;
  }
  const std::string map = "/grid/000010.prob.png";
  const std::string before = *ReadFile(run_ + map);
  EXPECT_EQ(RunProgram(Arguments(run_, {"--overwrite", "--profile=fast", "--seed=2"})).code, 4);
  EXPECT_TRUE(*ReadFile(run_ + map) != before) << "the seed does not show";
}

TEST_F(Resume, AnotherRunIsRefusedWithTheDifference) {
  fs::copy(whole_, run_, fs::copy_options::recursive);
  EXPECT_THAT(RunProgram(Arguments(run_, {"--resume", "--set=window=9"})),
              EndsWithLine(2, "window is '7' there and '9' here"));
  EXPECT_THAT(RunProgram(Arguments(run_, {"--resume", "--set=focal_ratio=0.7"})),
              Says(2, "focal_ratio is 'learnt' there and '0.7' here"));
  fs::rename(root_ + "/frames", root_ + "/elsewhere");
  WritePatchDrive(root_ + "/second");
  fs::rename(root_ + "/second/frames", root_ + "/frames");
  EXPECT_THAT(RunProgram(Arguments(run_, {"--resume"})),
              Says(2, "the size of the frames is 160 x 96 there and 192 x 128 here"));
  EXPECT_EQ(RunProgram(Arguments(run_, {"--resume", "--overwrite"})).code, 2);
}

TEST_F(Resume, ADoneRunStaysAndALongerOneGoesOn) {
  std::vector<std::string> short_run = Arguments(run_, {"--max_frames=10"});
  EXPECT_EQ(RunProgram(short_run).code, 4);
  const ProgramOutcome again = RunProgram(Arguments(run_, {"--max_frames=10", "--resume"}));
  EXPECT_EQ(again.code, 4);
  EXPECT_THAT(again.out, HasSubstr("holds the whole run already"));
  EXPECT_EQ(RunProgram(Arguments(run_, {"--resume"})).code, 4);
  EXPECT_EQ(CompareRuns(whole_, run_), "");
}

// The lines say which device made a frame, where it is not the run's.
TEST_F(Resume, OnAnotherDeviceWhereThatIsAllowed) {
  if (RunFolder::Open(whole_)->ReadDescription()->device.find("reference") != std::string::npos) {
    GTEST_SKIP() << "the program runs on the reference device already";
  }
  ASSERT_EQ(RunProgram(Arguments(run_, {"--max_frames=10"})).code, 4);
  const std::vector<std::string> other = {"--resume", "--device=reference"};
  EXPECT_THAT(RunProgram(Arguments(run_, other)), EndsWithLine(2, "or add --allow_other_device"));
  std::vector<std::string> allowed = other;
  allowed.push_back("--allow_other_device");
  EXPECT_EQ(RunProgram(Arguments(run_, allowed)).code, 4);
  const RunFolder folder = *RunFolder::Open(run_);
  EXPECT_EQ(folder.ReadDescription()->device, RunFolder::Open(whole_)->ReadDescription()->device);
  const std::vector<FrameLine> lines = *folder.ReadLines();
  ASSERT_EQ(lines.size(), static_cast<size_t>(kFrames));
  for (const FrameLine& line : lines) {  // the last checkpoint is that after frame 7
    EXPECT_EQ(line.map_device.find("reference") != std::string::npos, line.index > 7) << line.index;
  }
  EXPECT_EQ(RunProgram(Arguments(run_, {"--allow_other_device"})).code, 2);
}

// Two programs that write into one folder would mix their lines.
TEST_F(Resume, OneProgramAtATime) {
  const FolderLock lock = Value(FolderLock::Take(whole_));
  for (const char* flag : {"--resume", "--overwrite"}) {
    EXPECT_THAT(RunProgram(Arguments(whole_, {flag})),
                Says(2, "another program is writing into " + whole_))
        << flag;
  }
  EXPECT_EQ(RunFolder::Open(whole_)->ReadLines()->size(), static_cast<size_t>(kFrames));
}

// A limit on the size of files stands for a full disk.
TEST_F(Resume, AFullDiskIsSaidAndTheRunGoesOnOnceThereIsRoom) {
  // On the host: PoCL has to write where it compiles.
  const std::string device = "--device=reference";
  const std::string whole = root_ + "/whole_reference";
  ASSERT_EQ(RunProgram(Arguments(whole, {device})).code, 4);
  const pid_t process = fork();
  if (process == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{6000, 6000};
    setrlimit(RLIMIT_FSIZE, &limit);
    const pid_t program =
        StartProgram(Arguments(run_, {device}), root_ + "/out.txt", root_ + "/err.txt");
    _exit(WaitForProgram(program));
  }
  EXPECT_EQ(WaitForProgram(process), 1);
  const std::string error = *ReadFile(root_ + "/err.txt");
  EXPECT_THAT(error, HasSubstr("egosieve: cannot write "));
  EXPECT_EQ(CountLines(error), 1) << error;
  const RunFolder folder = *RunFolder::Open(run_);
  const std::vector<FrameLine> lines = *folder.ReadLines();
  EXPECT_GE(lines.size(), 1u);
  EXPECT_LT(lines.size(), static_cast<size_t>(kFrames));
  EXPECT_EQ(RunProgram(Arguments(run_, {device, "--resume"})).code, 4);
  EXPECT_EQ(CompareRuns(whole, run_), "");
}

}  // namespace
}  // namespace egosieve::tools
