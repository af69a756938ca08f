#include "tests/vision/labelling/same_labels.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace egosieve::vision {

void ExpectWellFormed(const LabelledFrame& frame) {
  ASSERT_EQ(frame.positions.size(), 2 * frame.probability.size());
  ASSERT_EQ(frame.other_positions.size(), frame.positions.size());
  for (int64_t i = 0; i < frame.size(); ++i) {
    EXPECT_TRUE(frame.probability[i] >= 0 && frame.probability[i] <= 1);
    EXPECT_TRUE(frame.positions[2 * i] >= 0 &&
                frame.positions[2 * i] <= frame.labelled.image.cols - 1);
    EXPECT_TRUE(frame.positions[2 * i + 1] >= 0 &&
                frame.positions[2 * i + 1] <= frame.labelled.image.rows - 1);
  }
  if (frame.outcome == LabelOutcome::kLabelled) {
    EXPECT_GT(frame.noise_pixels, 0.0) << "of a motion that is trusted";
    EXPECT_TRUE(frame.reason.empty());
  } else {
    EXPECT_EQ(frame.size(), 0);
    EXPECT_FALSE(frame.reason.empty());
  }
}

void ExpectSame(const LabelledFrame& a, const LabelledFrame& b) {
  EXPECT_EQ(a.outcome, b.outcome);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.first_index, b.first_index);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.other_positions, b.other_positions);
  EXPECT_EQ(a.probability, b.probability);
  EXPECT_EQ(a.motion_model, b.motion_model);
  EXPECT_EQ(a.noise_pixels, b.noise_pixels);
}

}  // namespace egosieve::vision
