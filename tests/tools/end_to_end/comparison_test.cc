// The commands that score many drives or many methods, as a user runs them.
#include <filesystem>
#include <fstream>

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

TEST(Compare, TellsMethodsOverDrivesAndItsArcsineIsTheSegmenter) {
  const std::string root = FreshFolder(), suite = root + "/suite", out = root + "/out";
  PatchDriveOptions options;
  options.frames = 5;
  WritePatchDrive(suite + "/one", options);
  const ProgramOutcome outcome =
      RunProgram({"lab", "compare", suite, "--out=" + out, "--budget=300", "--no_plots",
                  "--methods=arcsine,svm,ransac,homography_flow", "--progress=none",
                  "--variant=few=--profile=paper --budget=200"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("1 drives compared, 0 failed"),
                                 HasSubstr("RANSAC distance at the features themselves")));
  const Json all = Json::parse(*ReadFile(out + "/compare.json"));
  ASSERT_EQ(all.at("profiles").size(), 3u);
  EXPECT_EQ(all.at("profiles")[0].at("profile"), "paper");
  EXPECT_EQ(all.at("profiles")[2].at("profile"), "few");
  EXPECT_EQ(all.at("profiles")[1].at("flags").at("budget"), "300");
  EXPECT_EQ(all.at("profiles")[2].at("flags").at("budget"), "200");
  const Json& json = all.at("profiles")[1];
  ASSERT_EQ(json.at("methods").size(), 4u);
  EXPECT_EQ(CountLines(*ReadFile(out + "/compare.csv")), 1 + 3 * 4 * 5);

  const std::string run = root + "/run";
  ASSERT_EQ(RunProgram({"segment", suite + "/one/frames", "--out=" + run, "--budget=300",
                        "--progress=none", "--checkpoint_every=0"})
                .code,
            0);
  ASSERT_EQ(RunEvaluation({run, "--truth=" + suite + "/one/masks", "--no-plots"}).code, 0);
  const Json evaluation = Json::parse(*ReadFile(run + "/eval.json"));
  EXPECT_NEAR(json.at("methods")[0].at("scores").at("pooled_auc").get<double>(),
              evaluation.at("pooled_auc").get<double>(), 1e-9);
  EXPECT_NEAR(json.at("methods")[0].at("auc_over_frames").get<double>(),
              evaluation.at("mean_auc").get<double>(), 1e-9);
}

TEST(Method, ARivalHasARunFolderOfItsOwn) {
  const std::string root = FreshFolder(), run = root + "/run";
  PatchDriveOptions options;
  options.frames = 4;
  WritePatchDrive(root, options);
  const ProgramOutcome outcome =
      RunProgram({"segment", root + "/frames", "--out=" + run, "--method=homography_flow",
                  "--location_prior=0", "--ahead=0", "--progress=none"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(RunFolder::Open(run)->ReadDescription()->flags.at("method"), "homography_flow");
  EXPECT_FALSE(fs::exists(run + "/grid/000002.std.png"));
  std::ofstream(root + "/boxes.csv")
      << "frame,id,type,x1,y1,x2,y2,moving\n2,0,Car,10,10,30,30,0\n3,0,Car,10,10,30,30,0\n";
  const ProgramOutcome boxes = RunEvaluation({run, "--no-plots"});
  EXPECT_EQ(boxes.code, 0) << boxes.err;
  EXPECT_THAT(boxes.out, HasSubstr("standing vehicle"));
  EXPECT_EQ(Json::parse(*ReadFile(run + "/further.json")).at("boxes").at("frames"), 2);
  EXPECT_GE(Json::parse(*ReadFile(run + "/eval.json")).at("pooled_auc").get<double>(), 0.8);
  EXPECT_EQ(
      RunProgram({"reconstruct", run, "--what=probability,deviation", "--progress=none"}).code, 0);
  EXPECT_TRUE(fs::exists(run + "/full/000002.prob.png"));
  EXPECT_FALSE(fs::exists(run + "/full/000002.std.png"));
  const ProgramOutcome resumed = RunProgram(
      {"segment", root + "/frames", "--out=" + run, "--method=svm", "--resume", "--progress=none"});
  EXPECT_EQ(resumed.code, 2);
  EXPECT_THAT(resumed.err, HasSubstr("keeps no checkpoints"));
}

TEST(Compare, TruthThatDoesNotFitIsToldWithCounts) {
  const std::string root = FreshFolder();
  PatchDriveOptions options;
  options.frames = 5;
  WritePatchDrive(root + "/one", options);
  options.width_pixels = 64;
  WritePatchDrive(root + "/small", options);
  // Masks alone: beside frames they would be another drive's.
  fs::rename(root + "/small/masks", root + "/small_masks");
  fs::create_directory(root + "/half");
  for (const char* name : {"000001.png", "000002.png"}) {
    fs::copy(root + "/one/masks/" + name, root + "/half/" + name);
  }
  const auto compare = [&](const std::string& truth) {
    return RunProgram({"lab", "compare", root + "/one/frames", "--truth=" + truth,
                       "--out=" + root + "/out", "--methods=ransac", "--profiles=default",
                       "--no_plots", "--progress=none"});
  };
  const ProgramOutcome small = compare(root + "/small_masks");
  EXPECT_EQ(small.code, 2);
  EXPECT_THAT(small.err, HasSubstr("5 of 5 masks do not fit their frames, first:"));
  const ProgramOutcome half = compare(root + "/half");
  EXPECT_EQ(half.code, 0) << half.err;
  EXPECT_THAT(half.out, HasSubstr("left out: 3 of 5 frames without truth"));
  options.width_pixels = 192;
  options.frames = 4;
  WritePatchDrive(root + "/other", options);
  const ProgramOutcome other = compare(root + "/other/masks");
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("which are other frames"));
}

TEST(Compare, SyntheticDrivesAreThoseOfThisCall) {
  const std::string root = FreshFolder(), out = root + "/out";
  PatchDriveOptions options;
  options.frames = 5;
  WritePatchDrive(out + "/drives/former", options);
  const ProgramOutcome outcome =
      RunProgram({"lab", "compare", "--scenarios=street", "--frames=5", "--out=" + out,
                  "--methods=ransac", "--profiles=default", "--no_plots", "--progress=none"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("1 drives compared, 0 failed"));
  EXPECT_TRUE(fs::exists(out + "/drives/street/scene.json"));
}

TEST(Lab, AMistypedCommandTellsTheRightOne) {
  const ProgramOutcome outcome = RunProgram({"lab", "compar"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
  EXPECT_THAT(outcome.err,
              HasSubstr("unknown command compar; did you mean compare? see egosieve lab --help"));
}

TEST(Compare, WhatCannotBeIsRefusedBeforeWorkIsDone) {
  const std::string root = FreshFolder();
  const auto refused = [&](std::vector<std::string> arguments, int code, const std::string& why) {
    arguments.push_back("--progress=none");
    const ProgramOutcome outcome = RunProgram(arguments);
    EXPECT_EQ(outcome.code, code) << why;
    EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(why));
  };
  refused({"lab", "compare", root, "--out=" + root + "/out", "--methods=magic"}, 2,
          "no method 'magic'");
  refused({"lab", "compare", root, "--out=" + root + "/out"}, 3, "no sequence in");
  refused({"lab", "compare", root, "--out=" + root + "/out", "--profiles=magic"}, 2, "magic");
  refused({"lab", "compare", root, "--out=" + root + "/out", "--variant=paper=--budget=9"}, 2,
          "'paper' is named twice");
  refused({"lab", "compare", root, "--out=" + root + "/out", "--variant=x=--magic=9"}, 2, "x: ");
  refused({"lab", "compare", "--truth=x", "--out=" + root + "/out"}, 2, "no INPUT");
  refused({"evaluate", root}, 2, "evaluate is egosieve-eval now");
  refused({"lab", "compare", root, "--truth=" + root, "--scenarios=street", "--out=" + root + "/o"},
          2, "--scenarios");
  // The name that is no scenario comes last; no drive is made.
  refused({"lab", "compare", "--scenarios=,", "--out=" + root + "/out"}, 2, "no scenario;");
  refused({"lab", "compare", "--scenarios=street,magic", "--out=" + root + "/out"}, 2,
          "no scenario is called \"magic\"");
  EXPECT_FALSE(fs::exists(root + "/out/drives"));
}

}  // namespace
}  // namespace egosieve::tools
