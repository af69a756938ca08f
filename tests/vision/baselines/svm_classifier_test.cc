#include "vision/baselines/svm_classifier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace egosieve::vision {
namespace {

// Positive inside a ring that no line separates from the outside.
struct Ring {
  std::vector<float> inputs;
  std::vector<uint8_t> positive;

  explicit Ring(int count, uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto uniform = [&] { return 2.0 * static_cast<double>(random() >> 11) * 0x1p-53 - 1.0; };
    for (int i = 0; i < count; ++i) {
      const double x = uniform(), y = uniform();
      inputs.insert(inputs.end(), {static_cast<float>(x), static_cast<float>(y)});
      positive.push_back(std::hypot(x, y) < 0.6 ? 1 : 0);
    }
  }
  kernels::ConstMatrixView<float> view() const {
    return {inputs.data(), static_cast<int64_t>(positive.size()), 2};
  }
};

double ErrorRate(const std::vector<double>& decisions, const std::vector<uint8_t>& positive) {
  double wrong = 0.0;
  for (size_t i = 0; i < decisions.size(); ++i) {
    wrong += (decisions[i] > 0.0) != (positive[i] != 0) ? 1.0 : 0.0;
  }
  return wrong / static_cast<double>(decisions.size());
}

TEST(SvmClassifier, PositiveDecisionsAreThePositiveClass) {
  const Ring train(300, 1), test(300, 2);
  const auto machine = SvmClassifier::Train(train.view(), train.positive, {4.0, 10.0});
  ASSERT_TRUE(machine.ok()) << machine.status();
  // The ring's border within 0.05, where 300 points leave doubt, is 2 pi 0.6 0.1 / 4 = 9 % of the
  // square.
  EXPECT_LT(ErrorRate(machine->Decide(test.view()), test.positive), 0.09);
}

TEST(SvmClassifier, HeldOutDecisionsAreRight) {
  const Ring ring(300, 3);
  const auto decisions = CrossValidatedDecisions(ring.view(), ring.positive, {4.0, 10.0}, 3);
  ASSERT_TRUE(decisions.ok());
  EXPECT_LT(ErrorRate(*decisions, ring.positive), 0.12);
}

// Points with random classes: what has seen a point knows its class, what has not cannot.
TEST(SvmClassifier, HeldOutDecisionsHaveNotSeenThePoint) {
  Ring noise(300, 4);
  std::mt19937_64 random(5);
  for (uint8_t& positive : noise.positive) positive = random() % 2 == 0 ? 1 : 0;
  const SvmParameters sharp{1000.0, 100.0};
  const auto seen = SvmClassifier::Train(noise.view(), noise.positive, sharp);
  ASSERT_TRUE(seen.ok());
  EXPECT_LT(ErrorRate(seen->Decide(noise.view()), noise.positive), 0.1);
  const auto held = CrossValidatedDecisions(noise.view(), noise.positive, sharp, 3);
  ASSERT_TRUE(held.ok());
  EXPECT_GT(ErrorRate(*held, noise.positive), 0.38);  // 0.5 less four standard errors
}

TEST(ChooseSvmParameters, IsTheSameEachTimeAndFitsTheRing) {
  const Ring ring(200, 6);
  const auto first = ChooseSvmParameters(ring.view(), ring.positive, 3);
  const auto second = ChooseSvmParameters(ring.view(), ring.positive, 3);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(first->gamma, second->gamma);
  EXPECT_EQ(first->c, second->c);
  const auto decisions = CrossValidatedDecisions(ring.view(), ring.positive, *first, 3);
  EXPECT_LT(ErrorRate(*decisions, ring.positive), 0.15);
}

TEST(SvmClassifier, RefusesOneClassAndBadParameters) {
  const Ring ring(20, 7);
  EXPECT_EQ(SvmClassifier::Train(ring.view(), std::vector<uint8_t>(20, 0), {}).status().code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_FALSE(SvmClassifier::Train(ring.view(), ring.positive, {std::nan(""), 1.0}).ok());
  EXPECT_FALSE(SvmClassifier::Train(ring.view(), std::vector<uint8_t>(3, 1), {}).ok());
}

}  // namespace
}  // namespace egosieve::vision
