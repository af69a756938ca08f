#include "tools/lab/evaluate_features/evaluate_features.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/run_command.h"
#include "tools/lab/evaluate_features/evaluate_features_command.h"
#include "tools/lab/evaluate_features/feature_report.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using vision::ChoiceVerdict;

const auto kGoOn = [] { return true; };

std::string Root() {
  return ::testing::TempDir() + "/" +
         ::testing::UnitTest::GetInstance()->current_test_info()->name();
}

FeatureSequence PatchSequence(const std::string& root, int frames = 5) {
  PatchDriveOptions drive;
  drive.frames = frames;
  WritePatchDrive(root, drive);
  return {"patch", root + "/frames", root + "/masks"};
}

void WriteText(const std::string& path, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream(path) << text;
}

// The plane's homography explains all but the square, so distances rank it first; a fundamental
// matrix cannot do better than that.
TEST(EvaluateSequence, SeparatesASquareThatSlidesOverAPlane) {
  const auto score = EvaluateSequence(PatchSequence(Root()), {}, kGoOn);
  ASSERT_TRUE(score.ok()) << score.status();
  ASSERT_EQ(score->frames.size(), 4u);  // the first frame makes no pair
  EXPECT_EQ(score->CountUnlabelled(), 0);
  for (const AucOf& auc_of : {AucOf(ResidualAuc), AucOf(LabelAuc)}) {
    const auto mean = MeanAuc(score->frames, auc_of);
    ASSERT_TRUE(mean.has_value());
    EXPECT_GT(*mean, 0.95);
  }
  for (const FeatureFrame& frame : score->frames) {
    EXPECT_GT(frame.score.mover_count, 0) << frame.index;
    EXPECT_TRUE(frame.plain_auc.has_value()) << frame.index;
  }
  EXPECT_EQ(score->CountVerdicts(ChoiceVerdict::kWorse), 0);
  EXPECT_EQ(score->CountMotionModels().count("fundamental"), 0u);
}

TEST(EvaluateSequence, ScoresEveryKthPairAndCallsBackForEveryFrame) {
  EvaluateFeaturesOptions options;
  options.every = 3;
  options.plain_ransac = false;
  int calls = 0;
  const auto score = EvaluateSequence(PatchSequence(Root(), 6), options, [&] {
    ++calls;
    return true;
  });
  ASSERT_TRUE(score.ok()) << score.status();
  ASSERT_EQ(score->frames.size(), 2u);
  EXPECT_EQ(score->frames[0].index, 1);
  EXPECT_EQ(score->frames[1].index, 4);
  EXPECT_EQ(calls, 6);
  EXPECT_FALSE(score->frames[0].plain_auc.has_value());
}

TEST(EvaluateSequence, FramesWithoutTruthAreCountedAndAllMissingIsAnError) {
  const FeatureSequence sequence = PatchSequence(Root());
  std::filesystem::remove(sequence.truth + "/000002.png");
  EvaluateFeaturesOptions options;
  options.plain_ransac = false;
  const auto score = EvaluateSequence(sequence, options, kGoOn);
  ASSERT_TRUE(score.ok()) << score.status();
  EXPECT_EQ(score->frames.size(), 3u);
  EXPECT_EQ(score->frames_without_truth, 1);
  for (const int index : {1, 3, 4}) {
    std::filesystem::remove(absl::StrFormat("%s/%06d.png", sequence.truth, index));
  }
  EXPECT_EQ(EvaluateSequence(sequence, options, kGoOn).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(EvaluateSequence, MaskOfAnotherSizeIsNamed) {
  const FeatureSequence sequence = PatchSequence(Root());
  cv::imwrite(sequence.truth + "/000001.png", cv::Mat1b(7, 9, uint8_t{255}));
  const auto score = EvaluateSequence(sequence, {}, kGoOn);
  ASSERT_FALSE(score.ok());
  EXPECT_THAT(std::string(score.status().message()), HasSubstr("000001.png"));
}

TEST(EvaluateSequence, Cancels) {
  EXPECT_EQ(EvaluateSequence(PatchSequence(Root()), {}, [] { return false; }).status().code(),
            absl::StatusCode::kCancelled);
}

// Tracks of the plane and of the square, as the drive moves them: numbers in the file's names.
TEST(EvaluateSequence, ScoresAtLabelledTracks) {
  FeatureSequence sequence = PatchSequence(Root());
  std::string csv = "track,label,frame,x,y\n";
  int track = 0;
  for (const int label : {1, 2}) {
    for (int y = 40; y < 100; y += 12) {
      for (int x = 20; x < 180; x += 12) {
        const cv::Mat1b before = PatchMask({}, 1), after = PatchMask({}, 2);
        const bool square = before(y, x) > 0;
        if (square != (label == 2) || (!square && after(y, x) > 0)) continue;
        // The square's displacement is its mask's; the plane's does not matter here, only that it
        // is one: it is the labeller's own model that is evaluated.
        const cv::Moments a = cv::moments(before, true), b = cv::moments(after, true);
        const double dx = label == 2 ? b.m10 / b.m00 - a.m10 / a.m00 : 0.0;
        csv += absl::StrFormat("%d,%d,1,%d,%d\n%d,%d,2,%.3f,%d\n", track, label, x, y, track, label,
                               x + dx, y);
        ++track;
      }
    }
  }
  WriteText(Root() + "/tracks.csv", csv);
  sequence.truth = Root() + "/tracks.csv";
  EvaluateFeaturesOptions options;
  options.plain_ransac = false;
  const auto score = EvaluateSequence(sequence, options, kGoOn);
  ASSERT_TRUE(score.ok()) << score.status();
  const FeatureFrame& frame = score->frames[1];
  EXPECT_EQ(frame.index, 2);
  EXPECT_EQ(frame.score.scored_count, track);
  ASSERT_TRUE(frame.score.label_auc.has_value());
  EXPECT_GT(*frame.score.label_auc, 0.9);
}

TEST(FindFeatureSequences, NaturalOrderAndTheMasksOfASyntheticDrive) {
  for (const char* folder : {"b/clip10/frames", "b/clip10/masks", "b/clip9/frames", "a/frames",
                             "a/labels", "c/frames", "d/masks"}) {
    std::filesystem::create_directories(Root() + "/" + folder);
  }
  WriteText(Root() + "/b/clip10/scene.json", "{}");
  WriteText(Root() + "/b/clip9/tracks.csv", "track,label,frame,x,y\n");
  const auto sequences = FindFeatureSequences(Root());
  ASSERT_TRUE(sequences.ok()) << sequences.status();
  std::vector<std::string> names;
  for (const FeatureSequence& sequence : *sequences) names.push_back(sequence.name);
  EXPECT_THAT(names, ElementsAre("a", "b/clip9", "b/clip10"));
  EXPECT_THAT((*sequences)[1].truth, ::testing::EndsWith("clip9/tracks.csv"));
  EXPECT_THAT((*sequences)[2].truth, ::testing::EndsWith("clip10/masks"));
  EXPECT_TRUE(absl::IsNotFound(FindFeatureSequences(Root() + "/d").status()));
  EXPECT_TRUE(absl::IsNotFound(FindFeatureSequences(Root() + "/none").status()));
}

FeatureFrame Judged(double chosen, double rejected) {
  FeatureFrame frame;
  frame.outcome = "labelled";
  frame.motion_model = vision::MotionModelKind::kHomography;
  frame.score.residual_auc = chosen;
  frame.score.rejected_auc = rejected;
  frame.verdict = JudgeChoice(frame.score);
  return frame;
}

TEST(FeatureReport, CountsChoicesByTheStatedRule) {
  SequenceScore score;
  score.name = "s";
  score.frames = {Judged(0.9, 0.5), Judged(0.9, 0.895), Judged(0.895, 0.9), Judged(0.5, 0.9)};
  FeatureFrame unlabelled;
  unlabelled.outcome = "too_few_matches";
  score.frames.push_back(unlabelled);
  const auto json = nlohmann::json::parse(ToJson({score, score}, {}));
  const auto& choice = json["sequences"][0]["choice"];
  EXPECT_EQ(choice["judged"], 4);
  EXPECT_EQ(choice["better"], 1);
  EXPECT_EQ(choice["tied"], 2);
  EXPECT_EQ(choice["worse"], 1);
  EXPECT_EQ(choice["share_not_below"], 0.5);
  EXPECT_EQ(choice["share_better_of_untied"], 0.5);
  EXPECT_EQ(json["all"]["choice"]["judged"], 8);
  EXPECT_NEAR(json["all"]["residual_auc"].get<double>(), (0.9 + 0.9 + 0.895 + 0.5) / 4, 1e-12);
  EXPECT_TRUE(json["all"]["label_auc"].is_null());
  EXPECT_EQ(json["sequences"][0]["frames_without_labels"], 1);
  EXPECT_TRUE(json["sequences"][0]["frames"][4]["choice"].is_null());
  EXPECT_THAT(ToTable({score}), HasSubstr("0.500"));
}

TEST(EvaluateFeaturesCommand, WritesScoresOfASuite) {
  PatchSequence(Root() + "/suite/one", 3);
  PatchSequence(Root() + "/suite/two", 3);
  const std::string json = Root() + "/scores.json";
  const CommandOutcome outcome = RunCommandForTest(
      MakeEvaluateFeaturesCommand(),
      {Root() + "/suite", "--features_json=" + json, "--no_plain", "--progress=none"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto text = ReadFile(json);
  ASSERT_TRUE(text.ok()) << text.status();
  const auto scores = nlohmann::json::parse(*text);
  ASSERT_EQ(scores["sequences"].size(), 2u);
  EXPECT_FALSE(scores["sequences"][0]["residual_auc"].is_null());
  EXPECT_TRUE(scores["sequences"][0]["plain_auc"].is_null());
}

TEST(EvaluateFeaturesCommand, ScoresOneSequenceAgainstItsTruth) {
  const FeatureSequence sequence = PatchSequence(Root(), 3);
  const std::string json = Root() + "/scores.json";
  const CommandOutcome outcome =
      RunCommandForTest(MakeEvaluateFeaturesCommand(),
                        {sequence.frames, "--truth=" + sequence.truth, "--features_json=" + json,
                         "--no_plain", "--every=2", "--progress=none"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto scores = nlohmann::json::parse(*ReadFile(json));
  ASSERT_EQ(scores["sequences"].size(), 1u);
  EXPECT_EQ(scores["sequences"][0]["name"], sequence.frames);
  EXPECT_EQ(scores["sequences"][0]["frames_scored"], 1);
}

TEST(EvaluateFeaturesCommand, NoInputIsRefused) {
  const CommandOutcome nothing = RunCommandForTest(MakeEvaluateFeaturesCommand(), {});
  EXPECT_EQ(nothing.code, 2) << nothing.err;
  EXPECT_THAT(nothing.err, HasSubstr("INPUT is required"));
  const CommandOutcome missing =
      RunCommandForTest(MakeEvaluateFeaturesCommand(), {Root() + "/missing"});
  EXPECT_EQ(missing.code, 3) << missing.err;
}

}  // namespace
}  // namespace egosieve::tools
