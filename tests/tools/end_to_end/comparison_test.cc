// Evaluation of a run and of many drives, as a user runs it.
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/tools/testing/fresh_folder.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::ordered_json;

void WriteDrives(const std::string& suite) {
  PatchDriveOptions options;
  options.frames = 5;
  WritePatchDrive(suite + "/easy/one", options);
  options.frames = 4;
  WritePatchDrive(suite + "/easy/two", options);
  // A truth of another size, and frames without truth.
  WritePatchDrive(suite + "/wrong", options);
  options.width_pixels = 64;
  WritePatchDrive(suite + "/small", options);
  fs::remove_all(suite + "/wrong/masks");
  fs::rename(suite + "/small/masks", suite + "/wrong/masks");
}

TEST(Suite, ScoresWhatItCanAndSaysWhatFailed) {
  const std::string root = FreshFolder(), suite = root + "/suite", out = root + "/out";
  WriteDrives(suite);
  const std::vector<std::string> command = {
      "suite",      suite,      "--out=" + out, "--profiles=default,paper",
      "--no-plots", "--jobs=2", "--quiet",      "--segment-flags=--budget=300 --seed=3"};
  const ProgramOutcome outcome = RunEvaluation(command);
  EXPECT_EQ(outcome.code, 4) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("easy/one"), HasSubstr("mean easy"),
                    HasSubstr("failed: wrong, default: 4 masks of"),
                    HasSubstr("left out: 1 folders with frames, but without truth: small"),
                    HasSubstr("4 of 6 runs scored, 2 failed")));
  const Json json = Json::parse(*ReadFile(out + "/suite.json"));
  EXPECT_EQ(json.at("sequences").size(), 6u);
  EXPECT_GE(json.at("sequences")[0].at("mean_auc").get<double>(), 0.9);
  const RunFolder run = *RunFolder::Open(out + "/runs/paper/easy/one");
  EXPECT_EQ(run.ReadDescription()->flags.at("budget"), "300");
  EXPECT_EQ(run.ReadDescription()->seed, 3u);

  // Runs that are there are taken: the same figures, and their folders untouched.
  const auto written = fs::last_write_time(out + "/runs/paper/easy/one/frames.jsonl");
  EXPECT_EQ(RunEvaluation(command).code, 4);
  EXPECT_EQ(fs::last_write_time(out + "/runs/paper/easy/one/frames.jsonl"), written);
  const Json again = Json::parse(*ReadFile(out + "/suite.json"));
  EXPECT_EQ(again.at("sequences")[0].at("scores"), json.at("sequences")[0].at("scores"));
}

TEST(Evaluate, BoxesBesideTheFramesAreScored) {
  const std::string root = FreshFolder(), run = root + "/run";
  PatchDriveOptions options;
  options.frames = 4;
  WritePatchDrive(root, options);
  ASSERT_EQ(RunProgram({"segment", root + "/frames", "--out=" + run, "--budget=300", "--ahead=0",
                        "--progress=none"})
                .code,
            0);
  std::ofstream(root + "/boxes.csv")
      << "frame,id,type,x1,y1,x2,y2,moving\n2,0,Car,10,10,30,30,0\n3,0,Car,10,10,30,30,0\n";
  const ProgramOutcome boxes = RunEvaluation({run, "--no-plots"});
  EXPECT_EQ(boxes.code, 0) << boxes.err;
  EXPECT_THAT(boxes.out, HasSubstr("standing vehicle"));
  EXPECT_EQ(Json::parse(*ReadFile(run + "/further.json")).at("boxes").at("frames"), 2);
}

TEST(Evaluate, TheFormerCommandTellsTheNewOne) {
  const ProgramOutcome outcome = RunProgram({"evaluate", FreshFolder()});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("evaluate is egosieve-eval now"));
}

}  // namespace
}  // namespace egosieve::tools
