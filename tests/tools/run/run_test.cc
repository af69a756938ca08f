#include <signal.h>

#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "tests/testing/fresh_folder.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tests/tools/testing/run_comparison.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/run_folder.h"
#include "tools/run_folder/verdict.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::vector<std::string> Lines(const std::string& text) {
  return absl::StrSplit(text, '\n', absl::SkipEmpty());
}

std::map<std::string, fs::file_time_type> TimesIn(const std::string& folder) {
  std::map<std::string, fs::file_time_type> times;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && !FolderLock::IsLockFile(entry.path().filename().string())) {
      times[entry.path().string()] = entry.last_write_time();
    }
  }
  return times;
}

class Run : public testing::Test {
 protected:
  Run() : root_(FreshFolder()), frames_(root_ + "/frames"), out_(root_ + "/out") {}

  ProgramOutcome RunIt(const std::vector<std::string>& flags = {}) const {
    return RunProgram(std::vector<std::string>{"run", frames_, "-o", out_} + flags);
  }

  void ExpectAllFiles() const {
    for (const char* name :
         {"overlay.mp4", "report.html", "tracks.csv", "masks/000002.png", "ids/000002.png"}) {
      EXPECT_TRUE(fs::exists(out_ + "/" + name)) << name;
    }
  }

  std::string root_, frames_, out_;
};

TEST_F(Run, OfAVideoMakesEverythingAndTellsItInFiveLines) {
  ASSERT_THAT(
      RunProgram({"synthesize", "--scenario=crossing", "--frames=8", "--width=256", "--height=144",
                  "--video", "--out=" + root_ + "/made", "--progress=none"}),
      Succeeds());
  frames_ = root_ + "/made/video.mp4";
  const ProgramOutcome first = RunIt();
  ASSERT_EQ(first.code, 0) << first.err;
  ExpectAllFiles();
  EXPECT_THAT(Lines(first.out),
              ElementsAre(StartsWith("moved: "), StartsWith("sure: "), StartsWith("doubtful: "),
                          HasSubstr(out_ + ": report.html, overlay.mp4, "),
                          HasSubstr("egosieve masks " + out_ + " --for=")));
  const auto times = TimesIn(out_);
  const ProgramOutcome second = RunIt();
  EXPECT_EQ(second.code, 0) << second.err;
  EXPECT_EQ(second.out, out_ + " was finished before; nothing was done\n" + first.out);
  EXPECT_EQ(TimesIn(out_), times);
}

TEST_F(Run, MakesWhatIsMissingAndNothingElse) {
  WritePatchDrive(root_, SmallPatchDrive(6));
  ASSERT_THAT(RunIt({"--max-frames=4", "--no-video", "-j", "2"}), Succeeds());
  EXPECT_FALSE(fs::exists(out_ + "/overlay.mp4"));
  EXPECT_FALSE(fs::exists(out_ + "/masks/000005.png"));
  ASSERT_THAT(RunIt(), Succeeds());
  EXPECT_TRUE(fs::exists(out_ + "/masks/000005.png"));
  ExpectAllFiles();
  const auto times = TimesIn(out_);
  fs::remove(out_ + "/overlay.mp4");
  const ProgramOutcome again = RunIt();
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.out, StartsWith("moved: "));
  for (const auto& [path, time] : TimesIn(out_)) {
    const std::string name = fs::path(path).filename();
    EXPECT_EQ(time != times.at(path), name == "overlay.mp4" || name == "report.html") << path;
  }
}

TEST_F(Run, GoesOnAfterAKill) {
  WritePatchDrive(root_, SmallPatchDrive(20));
  ASSERT_THAT(RunIt({"--profile=fast"}), Succeeds());
  const std::string undisturbed = out_;
  for (const char* reached : {"frames.jsonl", "reconstruct.json"}) {
    out_ = root_ + "/killed_after_" + reached;
    const pid_t process = StartProgram({"run", frames_, "-o", out_, "--profile=fast"},
                                       root_ + "/out.txt", root_ + "/err.txt");
    WaitUntil([&] { return !ReadFile(out_ + "/" + reached).value_or("").empty(); });
    kill(process, SIGKILL);
    WaitForProgram(process);
    if (reached == std::string("reconstruct.json")) {
      const cv::Mat preview = cv::imread(out_ + "/preview.png");
      EXPECT_EQ(preview.cols, cv::imread(frames_ + "/000000.png").cols);
      EXPECT_THAT(*ReadFile(root_ + "/err.txt"), HasSubstr(out_ + "/preview.png shows the newest"));
    }
    EXPECT_THAT(RunIt({"--profile=fast"}), Succeeds());
    ExpectAllFiles();
    EXPECT_FALSE(fs::exists(out_ + "/preview.png"));
    for (const std::string& folder : {out_, undisturbed}) fs::remove(folder + "/report.html");
    EXPECT_EQ(CompareRuns(undisturbed, out_), "");
  }
}

TEST_F(Run, OfPicturesThatDoNotMoveIsMadeAndDoubted) {
  WritePatchDrive(root_, SmallPatchDrive(5));
  for (int i = 1; i < 5; ++i) {
    fs::copy_file(frames_ + "/000000.png", frames_ + "/00000" + std::to_string(i) + ".png",
                  fs::copy_options::overwrite_existing);
  }
  const ProgramOutcome outcome = RunIt();
  EXPECT_THAT(outcome, Says(4, "nothing was learnt"));
  EXPECT_THAT(outcome.out, HasSubstr("moved:     nothing, in 5 frames\n"));
  ExpectAllFiles();
  EXPECT_EQ(RunIt().code, 4);  // also where all is done
}

TEST_F(Run, RefusesWhatDoesNotFitAndWritesNothing) {
  WritePatchDrive(root_, SmallPatchDrive(4));
  const std::string frames = frames_;
  frames_ = root_ + "/no.mp4";
  EXPECT_EQ(RunIt().code, 3);
  ASSERT_TRUE(WriteFileAtomically(root_ + "/text.mp4", "no video").ok());
  frames_ = root_ + "/text.mp4";
  EXPECT_EQ(RunIt().code, 3);
  frames_ = "rtsp://camera/stream";
  EXPECT_THAT(RunIt(), Says(2, "egosieve segment"));
  EXPECT_FALSE(fs::exists(out_));
  frames_ = frames;
  out_ = root_ + "/text.mp4";
  EXPECT_THAT(RunIt(), Says(2, "text.mp4 is a file"));
  EXPECT_EQ(*ReadFile(out_), "no video");
  out_ = root_ + "/out";
  ASSERT_THAT(RunIt({"--max_frames=3"}), Succeeds());
  const auto times = TimesIn(out_);
  frames_ = out_;
  EXPECT_THAT(RunIt().err, HasSubstr("is a run folder; give the video"));
  frames_ = frames;
  const ProgramOutcome other = RunIt({"--profile=fast"});
  EXPECT_THAT(other, Says(2, "the run in " + out_ + " is another"));
  EXPECT_EQ(Lines(other.err).size(), 1u) << other.err;
  EXPECT_EQ(TimesIn(out_), times);
}

constexpr char kTracks[] =
    "frame,time_seconds,id,left,top,width,height,area,probability,sure\n"
    "1,0.100000,2,0,0,9,9,30,0.9000,0.5000\n"
    "1,0.100000,7,0,0,9,9,10,0.5000,0.5000\n"
    "3,0.300000,7,0,0,9,9,10,0.5000,0.5000\n";

TEST(ClosingLines, NameMoversByNumberAndTime) {
  const std::vector<FrameLine> lines(5);
  EXPECT_EQ(MoversLine(kTracks, lines),
            "2 movers, in 2 of 5 frames: number 7 from 0.1 to 0.3 s, number 2 from 0.1 to 0.1 s");
  std::string many = kTracks;
  for (int i = 10; i < 14; ++i) many += "4,0.4," + std::to_string(i) + ",0,0,9,9,10,0.5,0.5\n";
  EXPECT_THAT(MoversLine(many, lines), StartsWith("6 movers, in 3 of 5 frames; longest: number 7"));
  EXPECT_THAT(MoversLine(many, lines), ContainsRegex("^([^,]*,){4}[^,]*$"));
  EXPECT_EQ(MoversLine("", lines), "nothing, in 5 frames");
}

TEST(ClosingLines, TellHowSureTheMapsAre) {
  std::vector<FrameLine> lines(4);  // the last has no map
  lines[0].expected_overlap = 0.2;
  lines[1].expected_overlap = 0.6;
  lines[2].expected_overlap = 0.7;
  const std::string line = CertaintyLine(kTracks, lines);
  EXPECT_THAT(line, HasSubstr("IoU of 0.60 (median)"));
  EXPECT_THAT(line, HasSubstr("probability 0.74 on average"));  // (30 0.9 + 20 0.5) / 50
  EXPECT_EQ(CertaintyLine("", std::vector<FrameLine>(2)), "unknown");
}

}  // namespace
}  // namespace egosieve::tools
