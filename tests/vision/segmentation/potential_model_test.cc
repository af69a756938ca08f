#include "vision/segmentation/potential_model.h"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/runtime/context.h"

namespace egosieve::vision {
namespace {

struct Look {
  float v, red, green, blue;
};

constexpr Look kRed{0.1f, 0.6f, -0.5f, -0.5f};
constexpr Look kGrey{0.1f, 0.0f, 0.0f, 0.0f};
constexpr Look kBlue{0.1f, -0.5f, -0.4f, 0.6f};

class PotentialModelTest : public testing::Test {
 protected:
  PotentialModelTest() : context_(*kernels::OpenContext()) { options_.enabled = true; }

  // Adds places of a look, each with a u of its own and noise in the colours.
  void Add(const Look& look, int count, double label) {
    std::uniform_real_distribution<float> noise(-0.05f, 0.05f), place(-1.0f, 1.0f);
    for (int i = 0; i < count; ++i) {
      const float red = look.red + noise(random_), green = look.green + noise(random_),
                  blue = look.blue + noise(random_);
      descriptors_.insert(descriptors_.end(), {place(random_), look.v + noise(random_),
                                               (red + green + blue) / 3.0f, red, green, blue});
      labels_.push_back(label);
    }
  }

  // One frame of what was added.
  void Learn(PotentialModel& model, double seconds) {
    EXPECT_EQ(model.Learn(seconds, {descriptors_.data(), static_cast<int64_t>(labels_.size()), 6},
                          labels_),
              absl::OkStatus());
    descriptors_.clear();
    labels_.clear();
  }

  // A mover of one look before scenery of another, for some seconds.
  void Drive(PotentialModel& model, const Look& mover, double from, double to) {
    for (double seconds = from; seconds < to; seconds += 0.5) {
      Add(mover, 60, 0.98);
      Add(kGrey, 300, 0.02);
      Learn(model, seconds);
    }
  }

  static float At(const PotentialModel& model, const Look& look, float u = 0.0f) {
    const float mean = (look.red + look.green + look.blue) / 3.0f;
    const std::vector<float> descriptor = {u, look.v, mean, look.red, look.green, look.blue};
    const std::vector<float> appearance = AppearanceOf({descriptor.data(), 1, 6});
    float probability = -1.0f;
    kernels::PosteriorOutputs outputs;
    outputs.probability = &probability;
    EXPECT_TRUE(
        model.posterior()->Evaluate({appearance.data(), 1, PotentialModel::kInputs}, outputs).ok());
    return probability;
  }

  std::shared_ptr<kernels::Context> context_;
  PotentialOptions options_;
  std::vector<float> descriptors_;
  std::vector<double> labels_;
  std::mt19937 random_{7};
};

TEST_F(PotentialModelTest, TellsWhatLooksLikeTheMoversWhereverItIs) {
  PotentialModel model(context_, options_);
  EXPECT_EQ(model.posterior(), nullptr);
  Drive(model, kRed, 0.0, 10.0);
  ASSERT_NE(model.posterior(), nullptr);
  EXPECT_GT(At(model, kRed), 0.8f);
  EXPECT_LT(At(model, kGrey), 0.2f);
  EXPECT_EQ(At(model, kRed, -0.9f), At(model, kRed, 0.9f));
  const Look unseen{-0.5f, -0.9f, 0.9f, -0.9f};
  EXPECT_NEAR(At(model, unseen), 0.5, 0.1);
}

// Parked cars are labelled static: a tenth of the scenery is red. At red both classes meet, and
// with equal weights 1 : 0.1 of them decide: (1 - 0.1) / (1 + 0.1) = 0.82, p = 0.9.
TEST_F(PotentialModelTest, WhatStandsAmongTheSceneryStaysOnTheMoversSide) {
  PotentialModel model(context_, options_);
  for (double seconds = 0.0; seconds < 30.0; seconds += 0.5) {
    Add(kRed, 60, 1.0);
    Add(kGrey, 270, 0.0);
    Add(kRed, 30, 0.0);
    Learn(model, seconds);
  }
  EXPECT_GT(At(model, kRed), 0.75f);
  EXPECT_LT(At(model, kGrey), 0.2f);
}

// Few labels of movers weigh as much as all those of the scenery: at the same look neither wins.
TEST_F(PotentialModelTest, ClassesWeighTheSame) {
  PotentialModel model(context_, options_);
  for (int k = 0; k < 30; ++k) {
    if (k == 0) Add(kRed, 40, 1.0);
    Add(kRed, 300, 0.0);
    Learn(model, 0.5 * k);
  }
  EXPECT_NEAR(At(model, kRed), 0.5, 0.05);
}

TEST_F(PotentialModelTest, ForgetsOverItsMemory) {
  options_.memory_seconds = 20.0;
  PotentialModel model(context_, options_);
  Drive(model, kRed, 0.0, 20.0);
  const float before = At(model, kRed);
  Drive(model, kBlue, 20.0, 25.0);
  EXPECT_GT(At(model, kBlue), 0.6f);
  EXPECT_GT(At(model, kRed), 0.7f);  // a quarter of the memory is no reason to forget
  // Ten times the memory: a share of e^-10 of the points is left of what was red.
  Drive(model, kBlue, 25.0, 225.0);
  EXPECT_LT(At(model, kRed), 0.65f);
  EXPECT_LT(At(model, kRed), before - 0.2f);
  // Scenery alone makes it forget no mover.
  const float blue = At(model, kBlue);
  for (double seconds = 300.0; seconds < 350.0; seconds += 0.5) {
    Add(kGrey, 100, 0.0);
    Learn(model, seconds);
  }
  EXPECT_NEAR(At(model, kBlue), blue, 0.05);
}

TEST_F(PotentialModelTest, LearnsEveryHalfSecondFromLabelsThatAreSure) {
  PotentialModel model(context_, options_);
  Drive(model, kRed, 0.0, 2.0);
  const std::string before = *model.ToBytes();
  Add(kRed, 100, 0.0);
  Learn(model, 1.9);  // the last update was at 1.5
  Add(kRed, 100, 0.3);
  Add(kRed, 100, 0.7);
  Learn(model, 10.0);
  EXPECT_EQ(*model.ToBytes(), before);
}

TEST_F(PotentialModelTest, GoesOnFromItsBytes) {
  PotentialModel model(context_, options_), restored(context_, options_);
  Drive(model, kRed, 0.0, 10.0);
  const std::string bytes = *model.ToBytes();
  ASSERT_TRUE(restored.Restore(bytes).ok());
  EXPECT_EQ(*restored.ToBytes(), bytes);
  EXPECT_EQ(At(restored, kRed), At(model, kRed));
  random_.seed(3);
  Drive(model, kBlue, 10.0, 12.0);
  random_.seed(3);
  Drive(restored, kBlue, 10.0, 12.0);
  EXPECT_EQ(*restored.ToBytes(), *model.ToBytes());
  EXPECT_EQ(At(restored, kBlue), At(model, kBlue));
}

TEST_F(PotentialModelTest, BytesThatAreNoStateAreRefused) {
  PotentialModel model(context_, options_);
  Drive(model, kRed, 0.0, 3.0);
  const std::string bytes = *model.ToBytes();
  for (const std::string& damaged : {std::string(), std::string("rubbish"), bytes.substr(0, 300)}) {
    EXPECT_FALSE(model.Restore(damaged).ok());
  }
  EXPECT_EQ(*model.ToBytes(), bytes);
}

TEST_F(PotentialModelTest, OptionsAreChecked) {
  const auto refuses = [](auto change) {
    PotentialOptions options;
    change(options);
    return options.Validate().code() == absl::StatusCode::kInvalidArgument;
  };
  EXPECT_TRUE(PotentialOptions().Validate().ok());
  EXPECT_TRUE(refuses([](PotentialOptions& o) { o.memory_seconds = 0.0; }));
  EXPECT_TRUE(refuses([](PotentialOptions& o) { o.interval_seconds = std::nan(""); }));
  EXPECT_TRUE(refuses([](PotentialOptions& o) { o.points_per_class = 1; }));
  EXPECT_TRUE(refuses([](PotentialOptions& o) { o.arrivals = 0; }));
  EXPECT_TRUE(refuses([](PotentialOptions& o) { o.least_certainty = 1.0; }));
  EXPECT_TRUE(refuses([](PotentialOptions& o) { o.inducing_points = 0; }));
}

}  // namespace
}  // namespace egosieve::vision
