#include "tools/evaluate/evaluate_run.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fake_run.h"

namespace egosieve::tools {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

const auto kGoOn = [] { return true; };

std::string Root() {
  return testing::TempDir() + "/" + testing::UnitTest::GetInstance()->current_test_info()->name();
}

absl::StatusOr<Evaluation> Evaluate(const FakeRun& run, const EvaluateOptions& options = {}) {
  const absl::StatusOr<RunEvaluation> result = EvaluateRun(run.folder, run.masks, options, kGoOn);
  if (!result.ok()) return result.status();
  return result->evaluation;
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
  const FrameScores& frame = clear->frames[2];
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
  const FrameScores& frame = evaluation->frames[1];
  EXPECT_EQ(frame.static_pixels, 0);
  EXPECT_EQ(frame.void_pixels + frame.dynamic_pixels, 20 * 14);
  EXPECT_FALSE(frame.auc.has_value());
  EXPECT_EQ(evaluation->pooled_auc, 1.0);
}

TEST(EvaluateRun, MasksThatAreVoidEverywhereAreCountedAndNoFigureIsMadeOfThem) {
  const FakeRun run = WriteFakeRun(Root());
  const auto write_void = [&](int index) {
    cv::imwrite(run.masks + absl::StrFormat("/%06d.png", index), cv::Mat1b(64, 96, uint8_t{128}));
  };
  write_void(2);
  const absl::StatusOr<Evaluation> one = Evaluate(run);
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->frames.size(), 4u);
  EXPECT_EQ(one->frames_without_points, 1);
  EXPECT_THAT(ToTable(*one), HasSubstr("left out: 1 frame whose mask is void everywhere"));
  for (int i = 0; i < 6; ++i) write_void(i);
  const absl::Status all = Evaluate(run).status();
  EXPECT_EQ(all.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(all.message()), HasSubstr("void in 5"));
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

  // One too few: whose masks they are is not known, unless the order is asked for.
  std::filesystem::remove(run.masks + "/f.png");
  EXPECT_EQ(Evaluate(run).status().code(), absl::StatusCode::kInvalidArgument);
  options.match = MatchMasks::kOrder;
  EXPECT_EQ(Evaluate(run, options)->matched_by, "order");
}

TEST(EvaluateRun, MasksThatDoNotFitAreRefused) {
  const FakeRun run = WriteFakeRun(Root());
  cv::imwrite(run.masks + "/000002.png", cv::Mat1b(10, 10, uint8_t{0}));
  EXPECT_EQ(Evaluate(run).status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(Evaluate(run).status().message()),
              AllOf(HasSubstr("1 of 5 masks do not fit"),
                    HasSubstr("000002.png has 10 x 10 pixels, its frame 96 x 64")));
  EXPECT_EQ(EvaluateRun(run.folder, "/nowhere", {}, kGoOn).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(EvaluateRun(run.folder, run.folder.path(), {}, kGoOn).status().code(),
            absl::StatusCode::kNotFound);
  EvaluateOptions options;
  options.pixels = ScoredPixels::kFull;
  EXPECT_THAT(std::string(Evaluate(run, options).status().message()),
              HasSubstr("egosieve reconstruct"));
}

TEST(EvaluateRun, MasksForHalfTheFramesAreCounted) {
  const FakeRun run = WriteFakeRun(Root());
  for (int i : {1, 3, 5}) std::filesystem::remove(run.masks + absl::StrFormat("/%06d.png", i));
  const absl::StatusOr<Evaluation> evaluation = Evaluate(run);
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_EQ(evaluation->frames.size(), 2u);  // 2 and 4; 0 has the prior
  EXPECT_EQ(evaluation->frames_without_mask, 3);
  EXPECT_THAT(ToTable(*evaluation), HasSubstr("left out: 3 frames without a mask"));
}

TEST(EvaluateRun, TruthOfOneClassHasNoAuc) {
  const FakeRun run = WriteFakeRun(Root());
  for (int i = 0; i < 6; ++i) {
    cv::imwrite(run.masks + absl::StrFormat("/%06d.png", i), cv::Mat1b(64, 96, uint8_t{0}));
  }
  const absl::StatusOr<Evaluation> evaluation = Evaluate(run);
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_FALSE(evaluation->pooled_auc.has_value());
  EXPECT_FALSE(evaluation->mean_auc.has_value());
  // Of 20 x 14 grid pixels in each of 5 frames those in the disc, whose p is 0.9, are alarms.
  EXPECT_GT(evaluation->scores.at("false_positive_rate_without_movers").get<double>(), 0.05);
  EXPECT_THAT(ToTable(*evaluation), EndsWith("pooled AUC: none, the truth has one class only\n"));
  EXPECT_THAT(ToTable(*evaluation), Not(HasSubstr("in the pooled one")));
}

TEST(EvaluateRun, TheTruthOfAnotherDriveIsRefused) {
  const FakeRun run = WriteFakeRun(Root());
  const std::string other = Root() + "/other";
  std::filesystem::create_directories(other + "/frames");
  std::filesystem::copy(run.masks, other + "/masks");
  cv::imwrite(other + "/frames/000000.png", cv::Mat3b(64, 96, cv::Vec3b(9, 9, 9)));
  const absl::StatusOr<RunEvaluation> evaluation =
      EvaluateRun(run.folder, other + "/masks", {}, kGoOn);
  EXPECT_EQ(evaluation.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(evaluation.status().message()),
              AllOf(HasSubstr("which are other frames"), HasSubstr(run.frames)));
}

// The disc's centre is a mover, the corner stands still; p is 0.9 and 0.2 there, give or take 0.05.
std::string WriteTracks(const std::string& path, double outside_x) {
  std::string csv = "track,label,frame,x,y\n";
  for (int i = 0; i < 6; ++i) {
    const int radius = 64 / 5;
    absl::StrAppendFormat(&csv, "0,2,%d,%d,32.5\n", i, radius + (i * 7) % (96 - 2 * radius));
    absl::StrAppendFormat(&csv, "1,1,%d,94.25,1.5\n2,1,%d,%g,5\n", i, i, outside_x);
  }
  std::ofstream(path) << csv;
  return path;
}

TEST(EvaluateRun, TracksTakeTheMapBetweenGridPixels) {
  const FakeRun run = WriteFakeRun(Root());
  const std::string tracks = WriteTracks(Root() + "/tracks.csv", 96.5);
  const absl::StatusOr<RunEvaluation> run_evaluation = EvaluateRun(run.folder, tracks, {}, kGoOn);
  ASSERT_TRUE(run_evaluation.ok()) << run_evaluation.status();
  const Evaluation& evaluation = run_evaluation->evaluation;
  EXPECT_EQ(evaluation.truth_kind, "tracks");
  EXPECT_EQ(evaluation.matched_by, "name");
  EXPECT_EQ(evaluation.pixels, "interpolated from grid");
  EXPECT_EQ(evaluation.frames.size(), 5u);
  EXPECT_EQ(evaluation.points, 18);
  EXPECT_EQ(evaluation.points_outside, 5);  // frame 0 is not scored: the prior
  EXPECT_EQ(evaluation.frames[0].static_pixels, 1);
  EXPECT_EQ(evaluation.frames[0].dynamic_pixels, 1);
  EXPECT_EQ(evaluation.pooled_auc, 1.0);
  EXPECT_EQ(evaluation.frames[0].iou, 1.0);
  EXPECT_FALSE(evaluation.frames[0].boundary_f.has_value());
  EXPECT_TRUE(evaluation.scores.at("false_objects_per_frame").is_null());
  EXPECT_THAT(ToTable(evaluation),
              HasSubstr("left out: 5 of 18 labelled points, outside the image"));
}

TEST(EvaluateRun, TracksThatNameOtherFramesAreRefusedWithCounts) {
  const FakeRun run = WriteFakeRun(Root());
  std::ofstream(Root() + "/tracks.csv") << "track,label,frame,x,y\n0,1,70,1,1\n1,2,71,5,5\n";
  const absl::StatusOr<RunEvaluation> none =
      EvaluateRun(run.folder, Root() + "/tracks.csv", {}, kGoOn);
  EXPECT_EQ(none.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(none.status().message()),
              AllOf(HasSubstr("6 frames"), HasSubstr("truth for 2 frames")));
  std::ofstream(Root() + "/tracks.csv") << "track,label,frame,x,y\n0,1,2,500,1\n1,2,2,-5,5\n";
  const absl::StatusOr<RunEvaluation> outside =
      EvaluateRun(run.folder, Root() + "/tracks.csv", {}, kGoOn);
  EXPECT_THAT(std::string(outside.status().message()), HasSubstr("2 points outside the image"));
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
