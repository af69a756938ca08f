#include "vision/labelling/gap_choice.h"

#include <gtest/gtest.h>

#include <cmath>

namespace egosieve::vision {
namespace {

constexpr int kLongest = 5;

// What the gap settles at where a picture brings so much parallax.
void Observe(double parallax_pixels, int gap, int longest, GapState& state) {
  ObserveParallax(parallax_pixels, gap, longest, kCalibratedGap, state);
}

int SettledGap(double pixels_a_picture, GapState state = {}) {
  for (int t = 0; t < 60; ++t) {
    Observe(pixels_a_picture * state.gap, state.gap, kLongest, state);
  }
  return state.gap;
}

// Three pixels of parallax are wanted.
TEST(GapChoice, LessParallaxMakesItLonger) {
  EXPECT_EQ(SettledGap(4.0), 1);  // driving
  EXPECT_EQ(SettledGap(2.6), 1);
  EXPECT_EQ(SettledGap(1.8), 2);
  EXPECT_EQ(SettledGap(1.1), 3);
  EXPECT_EQ(SettledGap(0.78), 4);        // walking pace, in small pictures
  EXPECT_EQ(SettledGap(0.2), kLongest);  // in the hand
  EXPECT_EQ(SettledGap(0.0), kLongest);  // standing
}

// Of a model that is selected, less than 0.35 px of parallax is none.
TEST(GapChoice, SelectedModelsGainNothingWithoutParallax) {
  for (const double pixels : {0.2, 0.0}) {
    GapState state;
    for (int t = 0; t < 60; ++t) {
      ObserveParallax(pixels * state.gap, state.gap, kLongest, kSelectedModelGap, state);
    }
    EXPECT_EQ(state.gap, 1) << pixels;
  }
}

TEST(GapChoice, StaysWhereItIsNearABorder) {
  GapState state;
  for (int t = 0; t < 60; ++t) Observe(1.5 * state.gap, state.gap, kLongest, state);
  ASSERT_EQ(state.gap, 2);
  // 3 / p is 1.9 and 2.2 in turn.
  for (int t = 0; t < 20; ++t) {
    Observe((t % 2 == 0 ? 1.58 : 1.36) * state.gap, state.gap, kLongest, state);
    EXPECT_EQ(state.gap, 2) << t;
  }
  EXPECT_EQ(SettledGap(6.0, state), 1);
}

TEST(GapChoice, NonsenseChangesNothing) {
  GapState state;
  Observe(3.0, 3, kLongest, state);
  const GapState before = state;
  Observe(std::nan(""), 1, kLongest, state);
  Observe(INFINITY, 1, kLongest, state);
  Observe(-1.0, 1, kLongest, state);
  Observe(1.0, 0, kLongest, state);
  EXPECT_EQ(state.gap, before.gap);
  EXPECT_EQ(state.log_parallax, before.log_parallax);
}

}  // namespace
}  // namespace egosieve::vision
