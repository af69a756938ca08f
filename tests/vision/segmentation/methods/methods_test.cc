#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "kernels/runtime/context.h"
#include "tests/vision/segmentation/moving_square.h"
#include "vision/segmentation/methods/map_method.h"
#include "vision/segmentation/methods/method_segmenter.h"
#include "vision/segmentation/online_segmenter.h"

namespace egosieve::vision {
namespace {

using ::testing::HasSubstr;

OnlineSegmenterOptions Options() {
  OnlineSegmenterOptions options = OnlineSegmenterOptions::Paper();
  options.labeller.feature_count = 800;
  options.labeller.motion_model = MotionModelChoice::kHomography;  // the drive is a plane
  options.learner.training.annealing_evaluations = 20;
  options.learner.random_start = false;
  options.labeller.paper_distance_pixels = 10.0;  // else a square that moves by 7 has no label
  return options;
}

std::vector<std::string> AllNames() {
  std::vector<std::string> names;
  for (const MethodName& method : MethodNames()) names.push_back(method.name);
  return names;
}

// The share of pairs (pixel of the square, other pixel) that the map orders rightly.
double Auc(const MovingSquare& drive, const SegmentationMap& map) {
  std::vector<float> inside, outside;
  for (int row = 0; row < map.grid.rows(); ++row) {
    for (int column = 0; column < map.grid.columns(); ++column) {
      const cv::Point pixel(map.grid.x_pixels(column), map.grid.y_pixels(row));
      (drive.Square(map.frame_index).contains(pixel) ? inside : outside)
          .push_back(map.probability[row * map.grid.columns() + column]);
    }
  }
  double ordered = 0.0;
  for (const float a : inside) {
    for (const float b : outside) ordered += a > b ? 1.0 : a == b ? 0.5 : 0.0;
  }
  return ordered / (static_cast<double>(inside.size()) * static_cast<double>(outside.size()));
}

class MethodsTest : public testing::Test {
 protected:
  std::unique_ptr<MethodSegmenter> Make(const std::vector<std::string>& names,
                                        const OnlineSegmenterOptions& options = Options()) {
    auto segmenter = MethodSegmenter::Create(*kernels::OpenContext(), options, names);
    EXPECT_TRUE(segmenter.ok()) << segmenter.status();
    return *std::move(segmenter);
  }

  MovingSquare drive_;
};

// The square is a sixth of the picture's height and moves by 7 pixels against the wall: every
// method has what it needs, and a map that has understood nothing has 0.5.
TEST_F(MethodsTest, EveryMethodFindsTheSquare) {
  const auto segmenter = Make(AllNames());
  MethodAnswers answers;
  for (int index = 0; index < 6; ++index) {
    auto result = segmenter->Process(drive_.At(index));
    ASSERT_TRUE(result.ok()) << result.status();
    answers = *std::move(result);
  }
  ASSERT_EQ(answers.answers.size(), MethodNames().size());
  for (size_t i = 0; i < answers.answers.size(); ++i) {
    const MethodAnswer& answer = answers.answers[i];
    const std::string name = MethodNames()[i].name;
    EXPECT_EQ(static_cast<int64_t>(answer.map.probability.size()), answer.map.grid.size()) << name;
    for (const float probability : answer.map.probability) {
      ASSERT_TRUE(probability >= 0.0f && probability <= 1.0f) << name << " " << probability;
    }
    // A fundamental matrix says little of a plane that slides sideways with a square that does,
    // too.
    if (name != "dense_optical_flow") {
      EXPECT_GT(Auc(drive_, answer.map), 0.8) << name;
    }
    EXPECT_EQ(answer.record.model_size > 0, i < 3) << name;
    EXPECT_EQ(answer.map.deviation.empty(), i > 1) << name;
  }
}

// The comparison's arcsine is the segmenter, not something like it.
TEST_F(MethodsTest, ProcessesGiveTheSegmentersBytes) {
  for (const char* name : {"arcsine", "squared_exponential"}) {
    OnlineSegmenterOptions options = Options();
    options.learner.covariance = std::string(name) == "arcsine"
                                     ? kernels::CovarianceFunction::kArcsine
                                     : kernels::CovarianceFunction::kSquaredExponential;
    auto whole = OnlineSegmenter::Create(*kernels::OpenContext(), options);
    ASSERT_TRUE(whole.ok());
    // Another method beside it changes nothing.
    const auto segmenter = Make({"ransac", name});
    for (int index = 0; index < 4; ++index) {
      const auto expected = (*whole)->Process(drive_.At(index));
      const auto result = segmenter->Process(drive_.At(index));
      ASSERT_TRUE(expected.ok() && result.ok());
      const MethodAnswer& answer = result->answers[1];
      EXPECT_EQ(answer.map.probability, expected->map.probability) << name << " " << index;
      EXPECT_EQ(answer.map.deviation, expected->map.deviation) << name << " " << index;
      EXPECT_EQ(answer.record.model_size, expected->record.model_size);
    }
  }
}

TEST_F(MethodsTest, TheSegmentersResidualOfTheLabelsIsTheMethods) {
  OnlineSegmenterOptions options = Options(), without = options;
  options.labeller.labelled_side = LabelledSide::kCurrentFrame;
  without.labeller.labelled_side = LabelledSide::kCurrentFrame;
  options.residual_weight = 0.3;
  auto whole = OnlineSegmenter::Create(*kernels::OpenContext(), options);
  ASSERT_TRUE(whole.ok());
  const auto segmenter = Make({"arcsine"}, options), alone = Make({"arcsine"}, without);
  for (int index = 0; index < 4; ++index) {
    const auto expected = (*whole)->Process(drive_.At(index));
    const auto result = segmenter->Process(drive_.At(index));
    const auto bare = alone->Process(drive_.At(index));
    ASSERT_TRUE(expected.ok() && result.ok() && bare.ok());
    const std::vector<float>& probability = result->answers[0].map.probability;
    EXPECT_EQ(probability, expected->map.probability) << index;
    EXPECT_EQ(probability == bare->answers[0].map.probability, index == 0) << index;
  }
}

TEST_F(MethodsTest, FramesWithoutLabelsHaveTheirMaps) {
  const auto segmenter = Make(AllNames());
  const auto result = segmenter->Process(drive_.At(0));
  ASSERT_TRUE(result.ok()) << result.status();
  for (size_t i = 0; i < result->answers.size(); ++i) {
    const std::string name = MethodNames()[i].name;
    const float expected = i < 2 ? 0.5f : 0.0f;  // a process has a prior
    for (const float probability : result->answers[i].map.probability) {
      ASSERT_FLOAT_EQ(probability, expected) << name;
    }
    EXPECT_FALSE(result->answers[i].record.learnt) << name;
  }
}

TEST_F(MethodsTest, TheBudgetHoldsForAllThatLearn) {
  OnlineSegmenterOptions options = Options();
  options.learner.budget.budget = 60;
  options.learner.novelty_filter = false;
  options.learner.consistency_filter = false;
  const auto segmenter = Make({"arcsine", "squared_exponential", "svm"}, options);
  for (int index = 0; index < 3; ++index) {
    const auto result = segmenter->Process(drive_.At(index));
    ASSERT_TRUE(result.ok()) << result.status();
    for (const MethodAnswer& answer : result->answers) {
      EXPECT_LE(answer.record.model_size, 60);
      if (index > 0) {
        EXPECT_GT(answer.record.model_size, 30);
      }
    }
  }
}

TEST_F(MethodsTest, UnknownMethodsAreNamed) {
  const auto unknown = MethodSegmenter::Create(*kernels::OpenContext(), Options(), {"magic"});
  EXPECT_EQ(unknown.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(unknown.status().message()), HasSubstr("svm, labels, ransac"));
  EXPECT_FALSE(MethodSegmenter::Create(*kernels::OpenContext(), Options(), {}).ok());
}

TEST(PairsOf, RunFromTheFirstFrameToTheSecondOnEitherSide) {
  LabelledFrame labels;
  labels.first_index = 3;
  labels.second_index = labels.frame_index = 4;
  labels.probability = {0.5};
  labels.positions = {1.0, 2.0};
  labels.other_positions = {5.0, 6.0};
  labels.labelled.index = 3;
  EXPECT_EQ(PairsOf(labels)[0].x2, 5.0);
  EXPECT_EQ(PlacesInFrame(labels), (std::vector<double>{5.0, 6.0}));
  labels.labelled.index = 4;
  EXPECT_EQ(PairsOf(labels)[0].x2, 1.0);
  EXPECT_EQ(PlacesInFrame(labels), (std::vector<double>{1.0, 2.0}));
}

TEST(ScoreOfDistance, GrowsFromZeroToOneAndIsHalfAtThreePixels) {
  EXPECT_EQ(ScoreOfDistance(0.0), 0.0);
  EXPECT_EQ(ScoreOfDistance(3.0), 0.5);
  EXPECT_EQ(ScoreOfDistance(std::numeric_limits<double>::infinity()), 1.0);
  EXPECT_EQ(ScoreOfDistance(std::nan("")), 0.0);
}

}  // namespace
}  // namespace egosieve::vision
