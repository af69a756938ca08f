// The whole way of a drive through the program: synthesize, segment, evaluate, refine, render,
// report.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "absl/strings/str_split.h"
#include "kernels/files/atomic_file.h"
#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/lens_file.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::AllOf;
namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

void ExpectDone(const std::vector<std::string>& arguments) {
  EXPECT_THAT(RunProgram(arguments), Succeeds()) << arguments.front();
}

double PooledAuc(const std::string& run, const std::string& truth) {
  const ProgramOutcome outcome = RunEvaluation({run, "--truth=" + truth});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("pooled AUC [01]\\.[0-9]+ over [0-9]+ frames\n$"));
  return nlohmann::json::parse(*ReadFile(run + "/eval.json"))["pooled_auc"];
}

TEST(Chain, FromNothingToAReport) {
  const std::string root = FreshFolder(), run = root + "/run";
  ExpectDone({"synthesize", "--scenario=handheld", "--frames=10", "--width=400", "--height=240",
              "--out=" + root + "/drive", "--progress=none"});
  ExpectDone(
      {"segment", root + "/drive/frames", "--out=" + run, "--budget=800", "--progress=none"});
  // Better than chance, after nine pairs of a hard drive; AnEasyDriveIsSegmentedWell asks for more.
  EXPECT_GT(PooledAuc(run, root + "/drive/masks"), 0.5);
  ExpectDone({"reconstruct", run, "--what=tracks", "--progress=none"});  // the former name
  ExpectDone({"refine", run, "--what=masks,ids,tracks,deviation,class", "--progress=none"});
  ExpectDone({"render", run, "--images", "--progress=none"});
  ExpectDone({"report", run, "--progress=none"});

  const RunFolder folder = *RunFolder::Open(run);
  for (int index = 0; index < 10; ++index) {
    EXPECT_TRUE(fs::exists(root + "/drive/frames/" + folder.ReadLines()->at(index).image));
    EXPECT_TRUE(fs::exists(folder.FrameFile("grid", index, ".prob.png")));
    EXPECT_TRUE(fs::exists(folder.FrameFile("masks", index, ".png")));
    EXPECT_TRUE(fs::exists(folder.FrameFile("ids", index, ".png")));
    EXPECT_TRUE(fs::exists(folder.FrameFile("full", index, ".std.png")));
    EXPECT_TRUE(fs::exists(folder.FrameFile("full", index, ".class.png")));
    EXPECT_TRUE(fs::exists(folder.FrameFile("render", index, ".png")));
  }
  EXPECT_GT(fs::file_size(run + "/overlay.mp4"), 1000u);
  EXPECT_GT(fs::file_size(run + "/report.html"), 100000u);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(run)) {
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
  }

  // Another run in its place leaves nothing that was made from the former one.
  ExpectDone({"segment", root + "/drive/frames", "--out=" + run, "--overwrite", "--max_frames=1",
              "--checkpoint_every=0", "--progress=none"});
  std::set<std::string> left;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(run)) {
    left.insert(fs::relative(entry.path(), run).string());
  }
  EXPECT_THAT(left,
              ElementsAre(".write.lock", "camera.json", "frames.jsonl", "grid",
                          "grid/000000.prob.png", "grid/000000.std.png", "run.json", "shots.json"));
}

TEST(Chain, AnEasyDriveIsSegmentedWell) {
  const std::string root = FreshFolder(), run = root + "/run";
  WritePatchDrive(root);
  // A flat picture that shifts tells no focal length: a camera that turns and one that moves
  // sideways see the same.
  ExpectDone({"segment", root + "/frames", "--out=" + run, "--budget=800", "--set=focal_ratio=2",
              "--progress=none"});
  EXPECT_GE(PooledAuc(run, root + "/masks"), 0.95);
}

// Without a first pass the labeller learns it, and the run's end tells it.
TEST(Chain, AFocalLengthLearntOnTheWayIsKept) {
  const std::string root = FreshFolder(), run = root + "/run";
  ExpectDone({"synthesize", "--scenario=handheld", "--frames=16", "--width=400", "--height=240",
              "--out=" + root + "/drive", "--progress=none"});
  ExpectDone({"segment", root + "/drive/frames", "--out=" + run, "--no_first_pass", "--budget=200",
              "--checkpoint_every=5", "--progress=none"});
  const auto learnt = Value(ReadLensFile(run + "/camera.json")).focal_ratio(),
             truth = Value(ReadLensFile(root + "/drive/camera.json")).focal_ratio();
  // Nearer than the middle of the prior.
  EXPECT_NEAR(std::log(learnt / truth), 0.0, 0.05);
}

// A run that is resumed reads it from the run folder.
TEST(Chain, TheFirstPassFindsTheLens) {
  const std::string root = FreshFolder(), run = root + "/run", parts = root + "/parts";
  ExpectDone({"synthesize", "--scenario=handheld", "--seed=101", "--frames=40",
              "--field_of_view=80", "--radial=-0.15", "--out=" + root + "/drive",
              "--progress=none"});
  const auto segment = [&](const std::string& out, const std::string& to) {
    ExpectDone({"segment", root + "/drive/frames", "--out=" + out, "--to=" + to, "--resume",
                "--budget=200", "--progress=none"});
  };
  segment(run, "2");
  segment(parts, "1");
  segment(parts, "2");
  const LensFile learnt = Value(ReadLensFile(run + "/camera.json")),
                 truth = Value(ReadLensFile(root + "/drive/camera.json"));
  EXPECT_NEAR(std::log(learnt.focal_ratio() / truth.focal_ratio()), 0.0, 0.04);
  EXPECT_NEAR(learnt.lens.distortion[0], -0.15, 0.02);
  const auto camera = nlohmann::json::parse(std::ifstream(run + "/camera.json"));
  EXPECT_EQ(camera["pairs"], 12);  // of the pass over the corrected pictures
  const auto map = [](const std::string& folder) {
    return Value(kernels::ReadFile(folder + "/grid/000002.prob.png"));
  };
  EXPECT_EQ(map(parts), map(run));
}

TEST(Chain, ProgressAsJsonIsJson) {
  const std::string root = FreshFolder();
  WritePatchDrive(root, {.frames = 3});
  const ProgramOutcome outcome = RunProgram(
      {"segment", root + "/frames", "--out=" + root + "/run", "--budget=100", "--progress=json"});
  int64_t done = 0, read_before = 0;
  for (const absl::string_view line : absl::StrSplit(outcome.err, '\n', absl::SkipEmpty())) {
    const auto json = nlohmann::json::parse(line.begin(), line.end(), nullptr, false);
    ASSERT_TRUE(json.is_object()) << line;
    if (json["command"] == "first pass") {
      EXPECT_EQ(json["done"], ++read_before);
      continue;
    }
    EXPECT_EQ(json["done"], ++done);
    EXPECT_EQ(json["total"], 3);
    EXPECT_TRUE(json["model_size"].is_number());
  }
  EXPECT_EQ(done, 3);
  EXPECT_GE(read_before, 3);
}

// Evaluation of a run and of many drives, as a user runs it.

void WriteDrives(const std::string& suite) {
  PatchDriveOptions options{.frames = 5};
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
                    HasSubstr("failed: wrong, default: the mask "),
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
  WritePatchDrive(root, {.frames = 4});
  ASSERT_THAT(RunProgram({"segment", root + "/frames", "--out=" + run, "--budget=300", "--ahead=0",
                          "--progress=none"}),
              Succeeds());
  std::ofstream(root + "/boxes.csv")
      << "frame,id,type,x1,y1,x2,y2,moving\n2,0,Car,10,10,30,30,0\n3,0,Car,10,10,30,30,0\n";
  const ProgramOutcome boxes = RunEvaluation({run, "--no-plots"});
  EXPECT_EQ(boxes.code, 0) << boxes.err;
  EXPECT_THAT(boxes.out, HasSubstr("standing vehicle"));
  EXPECT_EQ(Json::parse(*ReadFile(run + "/further.json")).at("boxes").at("frames"), 2);
}

}  // namespace
}  // namespace egosieve::tools
