// Maps that are made after the run have the bytes that segment would have written.
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class Infer : public testing::TestWithParam<const char*> {
 protected:
  static constexpr int kFrames = 16;
  static constexpr int kDamaged = 9;  // just behind a checkpoint

  Infer()
      : root_(testing::TempDir() + "/infer_" + GetParam()),
        whole_(root_ + "/whole"),
        run_(root_ + "/run") {
    WritePatchDrive(root_, SmallPatchDrive(kFrames));
    const std::string torn = root_ + absl::StrFormat("/frames/%06d.png", kDamaged);
    fs::resize_file(torn, fs::file_size(torn) / 2);
    EXPECT_EQ(Segment(whole_), 4);
  }

  int Segment(const std::string& out, const std::vector<std::string>& more = {}) const {
    return RunProgram(SegmentArguments(out, more)).code;
  }

  std::vector<std::string> SegmentArguments(const std::string& out,
                                            const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"segment",
                                          root_ + "/frames",
                                          "--out=" + out,
                                          "--budget=150",
                                          "--stride=8",
                                          "--progress=none",
                                          "--checkpoint_every=4",
                                          "--inducing_points=50",
                                          absl::StrFormat("--model=%s", GetParam())};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  ProgramOutcome InferMaps(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"infer", run_, "--progress=none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  // The indices of the frames that have a map by their lines, each with the maps' bytes of `whole`.
  std::vector<int64_t> CheckedMaps(const std::string& run) const {
    const std::vector<FrameLine> lines = *RunFolder::Open(run)->ReadLines();
    const std::vector<FrameLine> expected = *RunFolder::Open(whole_)->ReadLines();
    std::vector<int64_t> indices;
    for (FrameLine line : lines) {
      if (!line.has_map()) continue;
      FrameLine other = expected[line.index];
      line.milliseconds.clear();
      other.milliseconds.clear();
      EXPECT_EQ(ToText(line), ToText(other));
      for (const MapFile& file : kMapFiles) {
        if (!fs::exists(whole_ + "/" + file.folder)) continue;
        const std::string name =
            absl::StrFormat("/%s/%06d%s", file.folder, line.index, file.suffix);
        EXPECT_EQ(*ReadFile(run + name), *ReadFile(whole_ + name)) << name;
      }
      indices.push_back(line.index);
    }
    return indices;
  }

  static std::vector<int64_t> Range(int64_t begin, int64_t end, int64_t step = 1) {
    std::vector<int64_t> range;
    for (int64_t i = begin; i < end; i += step) range.push_back(i);
    return range;
  }

  std::string root_, whole_, run_;
};

INSTANTIATE_TEST_SUITE_P(Models, Infer, testing::Values("exact", "sparse"),
                         [](const auto& model) { return std::string(model.param); });

TEST_P(Infer, FillsInWhatLearnOnlyLeftOut) {
  ASSERT_EQ(Segment(run_, {"--learn_only"}), 4);
  EXPECT_TRUE(CheckedMaps(run_).empty());
  EXPECT_TRUE(fs::is_empty(run_ + "/grid"));
  // From within a stretch between checkpoints; then one that begins with the damaged frame, whose
  // map is that of the frame before it; then the rest.
  EXPECT_EQ(InferMaps({"--from=6", "--to=7"}).code, 0);
  EXPECT_EQ(CheckedMaps(run_), Range(6, 8));
  EXPECT_EQ(InferMaps({"--from=9", "--to=10", "--threads=1"}).code, 4);
  EXPECT_EQ(CheckedMaps(run_), Range(6, 11));
  EXPECT_EQ(InferMaps().code, 4);
  EXPECT_EQ(CheckedMaps(run_), Range(0, kFrames));
  const ProgramOutcome again = InferMaps();
  EXPECT_EQ(again.code, 4);
  EXPECT_THAT(again.out, HasSubstr("holds these maps already"));
}

TEST_P(Infer, FillsInWhatEveryLeftOutAlsoElsewhere) {
  ASSERT_EQ(Segment(run_, {"--every=3"}), 4);
  // A damaged frame has the last map before it: here that of frame 6, where `whole` has that of 8.
  const std::vector<FrameLine> every = *RunFolder::Open(run_)->ReadLines();
  for (const FrameLine& line : every) EXPECT_EQ(line.has_map(), line.index % 3 == 0);
  EXPECT_EQ(*ReadFile(run_ + "/grid/000009.prob.png"), *ReadFile(run_ + "/grid/000006.prob.png"));
  EXPECT_EQ(InferMaps({"--to=8"}).code, 0);
  EXPECT_EQ(InferMaps({"--from=10"}).code, 0);
  fs::remove_all(run_ + "/grid/000009.prob.png");
  EXPECT_EQ(InferMaps({"--from=9", "--to=9", "--overwrite"}).code, 4);
  EXPECT_EQ(CheckedMaps(run_), Range(0, kFrames));
  fs::remove_all(run_);
  ASSERT_EQ(Segment(run_, {"--learn_only"}), 4);
  fs::rename(root_ + "/frames", root_ + "/moved");
  EXPECT_EQ(InferMaps().code, 3);
  const std::string elsewhere = root_ + "/elsewhere";
  EXPECT_EQ(InferMaps({"--input=" + root_ + "/moved", "--out=" + elsewhere, "--to=8"}).code, 0);
  EXPECT_EQ(CheckedMaps(elsewhere), Range(0, 9));
  EXPECT_EQ(RunFolder::Open(elsewhere)->ReadLines()->size(), 9u);
  fs::rename(root_ + "/moved", root_ + "/frames");
  EXPECT_TRUE(CheckedMaps(run_).empty());
  EXPECT_EQ(InferMaps({"--every=5", "--stride=4", "--out=" + root_ + "/fine"}).code, 0);
  const RunFolder fine = *RunFolder::Open(root_ + "/fine");
  const RunDescription description = *fine.ReadDescription();
  EXPECT_EQ(description.grid.stride, 4);
  int maps = 0;
  const std::vector<FrameLine> lines = *fine.ReadLines();
  for (const FrameLine& line : lines) {
    EXPECT_EQ(line.has_map(), line.index % 5 == 0);
    if (line.has_map()) maps += fine.ReadGridMaps(line, description, true).ok();
  }
  EXPECT_EQ(maps, 4);
}

// A folder of --out is gone on with, by the same program or for other frames.
TEST_P(Infer, GoesOnWithAFolderThatItHasBegun) {
  ASSERT_EQ(Segment(run_, {"--learn_only"}), 4);
  const std::string out = root_ + "/out";
  EXPECT_EQ(InferMaps({"--out=" + out, "--to=3"}).code, 0);
  EXPECT_EQ(RunFolder::Open(out)->ReadDescription()->frames_answered, 4);
  // Killed between run.json and the lines; then before its maps were entered.
  fs::remove_all(out + "/log");
  EXPECT_EQ(InferMaps({"--out=" + out, "--to=3"}).code, 0);
  EXPECT_EQ(CheckedMaps(out), Range(0, 4));
  EXPECT_EQ(InferMaps({"--out=" + out, "--from=10"}).code, 0);
  EXPECT_EQ(InferMaps({"--out=" + out}).code, 4);
  EXPECT_EQ(CheckedMaps(out), Range(0, kFrames));
  const RunDescription description = *RunFolder::Open(out)->ReadDescription();
  EXPECT_EQ(description.ended, "done");
  EXPECT_TRUE(fs::equivalent(description.maps_from, run_)) << description.maps_from;
  EXPECT_EQ(description.frames_answered, kFrames - 1);
  EXPECT_EQ(description.frames_failed, 1);
  EXPECT_THAT(InferMaps({"--out=" + out}).out, HasSubstr("holds these maps already"));
  EXPECT_THAT(RunProgram({"infer", out}).err, HasSubstr("holds maps alone; make more: "));
  const ProgramOutcome other = InferMaps({"--out=" + out, "--stride=4"});
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("--stride is '8' there and '4' here"));
}

// One program writes a run at a time.
TEST_P(Infer, ASecondProgramOnTheFolderIsRefused) {
  ASSERT_EQ(Segment(run_, {"--learn_only"}), 4);
  const std::string out = root_ + "/out";
  EXPECT_EQ(InferMaps({"--out=" + out, "--to=3"}).code, 0);
  for (const std::string& folder : {run_, out}) {
    const absl::StatusOr<FolderLock> other = FolderLock::Take(folder);
    ASSERT_TRUE(other.ok()) << other.status();
    const ProgramOutcome refused =
        folder == run_ ? InferMaps() : InferMaps({"--out=" + out, "--from=4"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.err, HasSubstr("another program is writing into " + folder));
    EXPECT_EQ(CountLines(refused.err), 1) << refused.err;
  }
  EXPECT_TRUE(CheckedMaps(run_).empty());
  EXPECT_EQ(CheckedMaps(out), Range(0, 4));
}

// Files that are gone, whatever the lines say.
TEST_P(Infer, MakesMapsAgainThatAreMissing) {
  ASSERT_EQ(Segment(run_, {"--learn_only"}), 4);
  ASSERT_EQ(InferMaps().code, 4);
  fs::remove(run_ + "/grid/000005.prob.png");
  fs::resize_file(run_ + "/grid/000012.std.png", 0);
  const ProgramOutcome reconstruct = RunProgram({"reconstruct", run_, "--progress=none"});
  EXPECT_EQ(reconstruct.code, 3);
  EXPECT_THAT(reconstruct.err, HasSubstr("the map of frame 5"));
  EXPECT_THAT(reconstruct.err, HasSubstr("egosieve infer " + run_));
  EXPECT_EQ(CountLines(reconstruct.err), 1);
  EXPECT_THAT(InferMaps().out, HasSubstr("2 maps in"));
  EXPECT_EQ(CheckedMaps(run_), Range(0, kFrames));
  EXPECT_EQ(RunProgram({"reconstruct", run_, "--progress=none"}).code, 4);
}

class InferExact : public Infer {};

INSTANTIATE_TEST_SUITE_P(Models, InferExact, testing::Values("exact"),
                         [](const auto& model) { return std::string(model.param); });

TEST_P(InferExact, WithACovarianceFunctionThatIsASum) {
  const std::string covariance = "--covariance=matern52 + isotropic(linear)";
  ASSERT_EQ(Segment(whole_, {covariance, "--overwrite"}), 4);
  ASSERT_EQ(Segment(run_, {covariance, "--learn_only"}), 4);
  EXPECT_EQ(InferMaps().code, 4);
  EXPECT_EQ(CheckedMaps(run_), Range(0, kFrames));
}

TEST_P(InferExact, MakesThePotentialToo) {
  EXPECT_FALSE(fs::exists(whole_ + "/potential"));
  ASSERT_EQ(Segment(whole_, {"--potential", "--overwrite", "--fps=2"}), 4);
  EXPECT_TRUE(fs::exists(whole_ + "/potential/000015.png"));
  ASSERT_EQ(Segment(run_, {"--potential", "--learn_only", "--fps=2"}), 4);
  EXPECT_EQ(InferMaps({"--from=6", "--to=8"}).code, 0);
  fs::remove(run_ + "/potential/000007.png");
  EXPECT_EQ(InferMaps().code, 4);
  EXPECT_EQ(CheckedMaps(run_), Range(0, kFrames));
  ASSERT_EQ(Segment(run_, {"--overwrite", "--fps=2"}), 4);
  EXPECT_FALSE(fs::exists(run_ + "/potential"));
}

// Maps by another device are those maps but for float32's rounding, and the log tells whose they
// are. The mean is off by at most 7e-6 sigma_f^2 |alpha|_1 (kernels/ops/dense_posterior.h, n =
// 150). alpha_i is the residual at point i over the noise's variance: 150 residuals of 0.3 over
// 0.4^2 come to 280. The probability's slope is at most 0.4 a, and a about 2: 1.6e-3. Measured: one
// of the 65,535 levels.
TEST_P(InferExact, AnotherDeviceGivesTheMapsWithinRoundingAndIsNamed) {
  const std::string own = RunFolder::Open(whole_)->ReadDescription()->device;
  ASSERT_EQ(Segment(run_, {"--learn_only"}), 4);
  const ProgramOutcome outcome = InferMaps({"--device=reference", "--from=3", "--to=6"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("on reference"));
  EXPECT_EQ(InferMaps().code, 4);
  const RunFolder folder = *RunFolder::Open(run_), whole = *RunFolder::Open(whole_);
  const RunDescription description = *folder.ReadDescription();
  const std::vector<FrameLine> lines = *folder.ReadLines();
  double worst = 0.0;
  for (const FrameLine& line : lines) {
    const bool of_reference = line.index >= 3 && line.index <= 6;
    if (own.find("reference") == std::string::npos) {
      EXPECT_EQ(line.map_device.find("reference") != std::string::npos, of_reference) << line.index;
    }
    const FrameMaps maps = *folder.ReadGridMaps(line, description, true);
    const FrameMaps expected = *whole.ReadGridMaps(line, description, true);
    const double difference = cv::norm(maps.probability, expected.probability, cv::NORM_INF);
    worst = std::max(worst, difference);
    EXPECT_TRUE(of_reference || difference == 0.0) << line.index;
  }
  EXPECT_LE(worst, 1.6e-3);
}

// Every command that reads maps says what is missing and which command makes it; afterwards it
// works.
TEST_P(InferExact, CommandsThatReadMapsAskForItAndWorkAfterIt) {
  const std::vector<std::vector<std::string>> commands = {{"render", "--no_video", "--images"},
                                                          {"reconstruct"}};
  const auto run = [&](std::vector<std::string> command) {
    command.insert(command.begin() + 1, {run_, "--progress=none"});
    return RunProgram(command);
  };
  ASSERT_EQ(Segment(run_, {"--learn_only"}), 4);
  for (const std::vector<std::string>& command : commands) {
    const ProgramOutcome outcome = run(command);
    EXPECT_EQ(outcome.code, 2) << command[0];
    EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("make them: egosieve infer " + run_)) << command[0];
  }
  EXPECT_FALSE(fs::exists(run_ + "/render"));
  EXPECT_FALSE(fs::exists(run_ + "/full"));
  // A report has much to say without maps.
  EXPECT_EQ(run({"report"}).code, 0);
  std::string page = *ReadFile(run_ + "/report.html");
  EXPECT_THAT(page, HasSubstr("15 of 16 frames have no map; egosieve infer"));
  EXPECT_THAT(page, Not(HasSubstr("of a frame moves")));

  // Some maps: what is there is shown, what is not is told.
  EXPECT_EQ(InferMaps({"--to=7"}).code, 0);
  const ProgramOutcome part = run({"reconstruct"});
  EXPECT_EQ(part.code, 4);  // the damaged frame
  EXPECT_THAT(part.out, HasSubstr("8 frames reconstructed"));
  EXPECT_THAT(part.err, HasSubstr("7 of 16 frames have no map; egosieve infer " + run_));
  EXPECT_EQ(run({"render", "--to=7"}).err, "");
  EXPECT_EQ(run({"render", "--from=10"}).code, 2);

  EXPECT_EQ(InferMaps().code, 4);
  for (const std::vector<std::string>& command : commands) {
    const ProgramOutcome outcome = run(command);
    EXPECT_EQ(outcome.code, command[0] == "render" || command[0] == "reconstruct" ? 4 : 0)
        << outcome.err;
    EXPECT_EQ(outcome.err, command[0] == "reconstruct"
                               ? "egosieve: warning: 1 frames could not be read and have no mask\n"
                               : "");
  }
  EXPECT_EQ(run({"report"}).code, 0);
  page = *ReadFile(run_ + "/report.html");
  EXPECT_THAT(page, Not(HasSubstr("have no map")));
  EXPECT_THAT(page, HasSubstr("data:image/jpeg"));
}

TEST_P(Infer, RefusesWhatItCannotDoInOneLine) {
  ASSERT_EQ(Segment(run_, {"--learn_only", "--max_frames=6"}), 0);
  const auto expect = [&](const std::vector<std::string>& arguments, int code,
                          const std::string& message) {
    const ProgramOutcome outcome = RunProgram(arguments);
    EXPECT_EQ(outcome.code, code);
    EXPECT_THAT(outcome.err, HasSubstr(message));
    EXPECT_EQ(CountLines(outcome.err), 1) << outcome.err;
  };
  expect({"infer", whole_}, 2, "has all its maps and kept no models");
  expect({"infer", run_, "--out=" + run_ + "/"}, 2, "is the run itself");
  expect({"infer", run_, "--stride=2"}, 2, "--stride=2 is not the run's 8");
  expect({"infer", run_, "--out=" + whole_}, 2, "holds another run: the run with the models is");
  expect({"infer", run_, "--from=6"}, 2, "has frames 0 to 5; choose --from and --to among them");
  expect({"infer", root_}, 3, "holds no run.json");
  PatchDriveOptions other;
  other.frames = 3;
  WritePatchDrive(root_ + "/other", other);
  expect({"infer", run_, "--input=" + root_ + "/other/frames"}, 2, "is not the input of the run");
  fs::remove(run_ + "/steps/000002.npz");
  expect({"infer", run_, "--progress=none"}, 3, "the model of frame 2 is missing");
}

}  // namespace
}  // namespace egosieve::tools
