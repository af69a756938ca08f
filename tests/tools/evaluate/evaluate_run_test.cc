#include "tools/evaluate/evaluate_run.h"

#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fake_run.h"

namespace egosieve::tools {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

const auto kGoOn = [] { return true; };

std::string Root() {
  return testing::TempDir() + "/" + testing::UnitTest::GetInstance()->current_test_info()->name();
}

absl::StatusOr<Evaluation> Evaluate(const FakeRun& run, const EvaluateOptions& options = {}) {
  return EvaluateRun(run.folder, run.masks, options, kGoOn);
}

// p is uniform in 0.6 +- 0.3 inside the disc and in 0.4 +- 0.3 outside: two intervals of width 0.6
// that overlap by 0.4, so AUC = 1 - (0.4 / 0.6)^2 / 2. With 1,450 positives among ten times as many
// negatives its standard error is at most 0.5 / sqrt(1450) = 0.013; three of them.
TEST(EvaluateRun, AgreesWithTheAreaOfOverlappingScores) {
  FakeRunOptions options;
  options.width_pixels = 320;
  options.height_pixels = 240;
  options.inside = 0.6;
  options.outside = 0.4;
  options.noise = 0.3;
  const absl::StatusOr<Evaluation> evaluation = Evaluate(WriteFakeRun(Root(), options));
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_NEAR(*evaluation->pooled_auc, 1.0 - 2.0 / 9.0, 0.04);
  EXPECT_NEAR(*evaluation->mean_auc, 1.0 - 2.0 / 9.0, 0.04);
}

TEST(EvaluateRun, SeparatedScoresHaveAreaOne) {
  FakeRunOptions options;
  options.width_pixels = 320;
  options.height_pixels = 240;
  const absl::StatusOr<Evaluation> clear = Evaluate(WriteFakeRun(Root(), options));
  ASSERT_TRUE(clear.ok()) << clear.status();
  EXPECT_EQ(clear->pooled_auc, 1.0);
  EXPECT_EQ(clear->mean_auc, 1.0);
  EXPECT_EQ(clear->frames.size(), 5u);
  EXPECT_EQ(clear->frames_of_prior, 1);
  EXPECT_EQ(clear->matched_by, "name");
  const FrameEvaluation& frame = clear->frames[2];
  EXPECT_EQ(frame.index, 3);
  EXPECT_EQ(frame.dynamic_pixels + frame.static_pixels, 65 * 49);
  // A disc of radius 48 on a grid of 5 pixels; its border is as long as 60 grid cells.
  EXPECT_NEAR(frame.dynamic_pixels, M_PI * 48 * 48 / 25, 60);
}

TEST(EvaluateRun, ThePriorIsLeftOutUnlessAskedFor) {
  const FakeRun run = WriteFakeRun(Root());
  EvaluateOptions options;
  options.with_prior = true;
  const absl::StatusOr<Evaluation> evaluation = Evaluate(run, options);
  ASSERT_TRUE(evaluation.ok());
  EXPECT_EQ(evaluation->frames.size(), 6u);
  EXPECT_EQ(evaluation->frames[0].auc, 0.5);  // one value everywhere: all ties
  EXPECT_EQ(evaluation->frames_of_prior, 0);
}

TEST(EvaluateRun, VoidPixelsCountForNothing) {
  const FakeRun run = WriteFakeRun(Root());
  cv::Mat1b mask = FakeMask({}, 2);
  mask.setTo(128, mask == 0);
  cv::imwrite(run.masks + "/000002.png", mask);
  const absl::StatusOr<Evaluation> evaluation = Evaluate(run);
  ASSERT_TRUE(evaluation.ok());
  const FrameEvaluation& frame = evaluation->frames[1];
  EXPECT_EQ(frame.static_pixels, 0);
  EXPECT_EQ(frame.void_pixels + frame.dynamic_pixels, 20 * 14);
  EXPECT_FALSE(frame.auc.has_value());
  EXPECT_EQ(evaluation->pooled_auc, 1.0);
}

TEST(EvaluateRun, CountsWhatHasNoPartner) {
  const FakeRun run = WriteFakeRun(Root());
  std::filesystem::remove(run.masks + "/000003.png");
  cv::imwrite(run.masks + "/000099.png", FakeMask({}, 0));
  const absl::StatusOr<Evaluation> evaluation = Evaluate(run);
  ASSERT_TRUE(evaluation.ok());
  EXPECT_EQ(evaluation->matched_by, "number");  // 000099 is no frame's name
  EXPECT_EQ(evaluation->frames.size(), 4u);
  EXPECT_EQ(evaluation->frames_without_mask, 1);
  EXPECT_EQ(evaluation->frames_without_map, 1);
  EXPECT_THAT(ToTable(*evaluation), HasSubstr("left out: 1 frame without a mask"));
  EXPECT_THAT(ToTable(*evaluation), EndsWith("pooled AUC 1.0000 over 4 frames\n"));
}

TEST(EvaluateRun, MasksMatchByNameNumberOrOrder) {
  const FakeRun run = WriteFakeRun(Root());
  // As a drive that starts at another number: names match, numbers would not.
  for (int i = 0; i < 6; ++i) {
    std::filesystem::rename(run.frames + absl::StrFormat("/%06d.png", i),
                            run.frames + absl::StrFormat("/%06d.png", 120 + i));
    std::filesystem::rename(run.masks + absl::StrFormat("/%06d.png", i),
                            run.masks + absl::StrFormat("/%06d.png", 120 + i));
  }
  EXPECT_EQ(Evaluate(run)->matched_by, "name");
  EXPECT_EQ(Evaluate(run)->pooled_auc, 1.0);
  EvaluateOptions options;
  options.match = MatchMasks::kNumber;
  EXPECT_EQ(Evaluate(run, options).status().code(), absl::StatusCode::kFailedPrecondition);

  for (int i = 0; i < 6; ++i) {
    std::filesystem::rename(run.masks + absl::StrFormat("/%06d.png", 120 + i),
                            run.masks + std::string("/") + "abcdef"[i] + ".png");
  }
  EXPECT_EQ(Evaluate(run)->matched_by, "order");
  EXPECT_EQ(Evaluate(run)->pooled_auc, 1.0);
  EXPECT_EQ(Evaluate(run, options).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(EvaluateRun, MasksThatDoNotFitAreRefused) {
  const FakeRun run = WriteFakeRun(Root());
  cv::imwrite(run.masks + "/000002.png", cv::Mat1b(10, 10, uint8_t{0}));
  EXPECT_THAT(std::string(Evaluate(run).status().message()),
              HasSubstr("000002.png has 10 x 10 pixels, its frame 96 x 64"));
  EXPECT_EQ(EvaluateRun(run.folder, "/nowhere", {}, kGoOn).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(EvaluateRun(run.folder, run.folder.path(), {}, kGoOn).status().code(),
            absl::StatusCode::kNotFound);
  EvaluateOptions options;
  options.pixels = ScoredPixels::kFull;
  EXPECT_THAT(std::string(Evaluate(run, options).status().message()),
              HasSubstr("egosieve reconstruct"));
}

TEST(Evaluation, ComesBackFromItsText) {
  const absl::StatusOr<Evaluation> evaluation = Evaluate(WriteFakeRun(Root()));
  ASSERT_TRUE(evaluation.ok());
  const absl::StatusOr<Evaluation> read = EvaluationFromText(ToText(*evaluation));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(ToText(*read), ToText(*evaluation));
  EXPECT_EQ(ToCsv(*read), ToCsv(*evaluation));
  EXPECT_FALSE(EvaluationFromText("{}").ok());
  EXPECT_FALSE(EvaluationFromText("").ok());
}

TEST(ReadTruthMask, AnyChannelMakesAColourMaskDynamic) {
  const std::string path = testing::TempDir() + "/colour.png";
  cv::Mat3b mask(1, 3, cv::Vec3b(0, 0, 0));
  mask(0, 1) = cv::Vec3b(0, 7, 0);
  mask(0, 2) = cv::Vec3b(128, 128, 128);
  cv::imwrite(path, mask);
  const absl::StatusOr<cv::Mat1b> truth = ReadTruthMask(path, cv::Size(3, 1));
  ASSERT_TRUE(truth.ok());
  EXPECT_EQ((*truth)(0, 0), kTruthStatic);
  EXPECT_EQ((*truth)(0, 1), kTruthDynamic);
  EXPECT_EQ((*truth)(0, 2), kTruthVoid);
}

}  // namespace
}  // namespace egosieve::tools
