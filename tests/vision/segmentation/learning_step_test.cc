#include "vision/segmentation/learning_step.h"

#include <string>

#include "gtest/gtest.h"

namespace egosieve::vision {
namespace {

using Kind = ModelOperation::Kind;
constexpr auto kArcsine = kernels::CovarianceFunction::kArcsine;

LearningStep MakeStep() {
  ModelOperation remove, add, set, labels;
  remove.kind = Kind::kRemove;
  remove.rows = {0, 3, 17};
  add.kind = Kind::kAdd;
  add.frame = 41;
  add.inputs = {0.1f, -0.25f, 1.0f / 3.0f, 1.0f};
  add.labels = {0.1, 1.0 / 3.0};
  set.kind = Kind::kSetHyperparameters;
  set.hyperparameters = gp::DefaultHyperparameters(kArcsine, 2);
  set.hyperparameters.noise_stddev = 1.0 / 7.0;
  labels.kind = Kind::kSetLabels;
  labels.labels = {0.25, 1.0 / 7.0, 0.75};
  return {{remove, add, set, remove, labels, add},
          {1.0 / 3.0, -0.7},
          std::string("a\0state", 7),
          std::string("\0another", 8),
          std::string("a\0third", 7)};
}

TEST(LearningStepTest, ComesBackAsItWas) {
  const LearningStep step = MakeStep();
  const auto bytes = SerializeStep(step);
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  const auto again = ParseStep(*bytes, kArcsine, 2);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->squash.a, step.squash.a);
  EXPECT_EQ(again->squash.b, step.squash.b);
  EXPECT_EQ(again->location_prior, step.location_prior);
  EXPECT_EQ(again->potential, step.potential);
  EXPECT_EQ(again->label_residual, step.label_residual);
  ASSERT_EQ(again->operations.size(), step.operations.size());
  for (size_t i = 0; i < step.operations.size(); ++i) {
    const ModelOperation &before = step.operations[i], &after = again->operations[i];
    EXPECT_EQ(after.kind, before.kind);
    EXPECT_EQ(after.frame, before.frame);
    EXPECT_EQ(after.inputs, before.inputs);
    EXPECT_EQ(after.labels, before.labels);
    EXPECT_EQ(after.rows, before.rows);
    EXPECT_EQ(after.hyperparameters.covariance.scales, before.hyperparameters.covariance.scales);
    if (before.kind == Kind::kSetHyperparameters) {
      EXPECT_EQ(after.hyperparameters.noise_stddev, before.hyperparameters.noise_stddev);
    }
  }
  EXPECT_EQ(*SerializeStep(*again), *bytes);
}

TEST(LearningStepTest, AStepOfNothingIsWhole) {
  const auto step = ParseStep(*SerializeStep({}), kArcsine, 6);
  ASSERT_TRUE(step.ok()) << step.status();
  EXPECT_TRUE(step->operations.empty());
}

TEST(LearningStepTest, DamageIsSaid) {
  const std::string bytes = *SerializeStep(MakeStep());
  EXPECT_EQ(ParseStep(bytes, kArcsine, 3).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(ParseStep(bytes, kArcsine, 1).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(ParseStep("", kArcsine, 2).status().code(), absl::StatusCode::kDataLoss);
  // A bit of any byte: the arrays' checksums, or what the arrays must be, tell it.
  for (size_t i = 0; i < bytes.size(); i += 7) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    const auto step = ParseStep(damaged, kArcsine, 2);
    if (step.ok()) {
      EXPECT_EQ(*SerializeStep(*step), bytes) << "byte " << i;
    }
  }
}

}  // namespace
}  // namespace egosieve::vision
