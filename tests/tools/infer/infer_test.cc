// Maps that are made after the run have the bytes that segment would have written.
#include <filesystem>

#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

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

  int Segment(const std::string& out, std::vector<std::string> more = {}) const {
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
    return RunProgram(arguments).code;
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
      for (const char* suffix : {"prob", "std"}) {
        const std::string name = absl::StrFormat("/grid/%06d.%s.png", line.index, suffix);
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
  EXPECT_EQ(InferMaps().code, 0);
  EXPECT_EQ(CheckedMaps(run_), Range(0, kFrames));
  const ProgramOutcome again = InferMaps();
  EXPECT_EQ(again.code, 0);
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
  expect({"infer", run_, "--stride=2"}, 2, "--stride=2 is not the run's 8");
  expect({"infer", run_, "--out=" + whole_}, 2, "holds a run already");
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
