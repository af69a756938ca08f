#include "vision/labelling/gap_choice.h"

#include <gtest/gtest.h>

#include <cmath>

namespace egosieve::vision {
namespace {

constexpr int kLongest = 5;

// What the gap settles at where a picture brings so much parallax.
int SettledGap(double pixels_a_picture, GapState state = {}) {
  for (int t = 0; t < 60; ++t) {
    ObserveParallax(pixels_a_picture * state.gap, state.gap, kLongest, state);
  }
  return state.gap;
}

TEST(GapChoice, LittleParallaxMakesItLongerAndNoneDoesNot) {
  EXPECT_EQ(SettledGap(4.0), 1);  // driving
  EXPECT_EQ(SettledGap(1.3), 1);
  EXPECT_EQ(SettledGap(0.9), 2);
  EXPECT_EQ(SettledGap(0.55), 3);
  EXPECT_EQ(SettledGap(0.39), 4);  // walking pace, in small pictures
  EXPECT_EQ(SettledGap(0.2), 1);   // in the hand
  EXPECT_EQ(SettledGap(0.0), 1);   // standing
}

TEST(GapChoice, StaysWhereItIsNearABorder) {
  GapState state;
  for (int t = 0; t < 60; ++t) ObserveParallax(0.75 * state.gap, state.gap, kLongest, state);
  ASSERT_EQ(state.gap, 2);
  // 1.5 / p is 1.9 and 2.2 in turn.
  for (int t = 0; t < 20; ++t) {
    ObserveParallax((t % 2 == 0 ? 0.79 : 0.68) * state.gap, state.gap, kLongest, state);
    EXPECT_EQ(state.gap, 2) << t;
  }
  EXPECT_EQ(SettledGap(3.0, state), 1);
}

TEST(GapChoice, NonsenseChangesNothing) {
  GapState state;
  ObserveParallax(3.0, 3, kLongest, state);
  const GapState before = state;
  ObserveParallax(std::nan(""), 1, kLongest, state);
  ObserveParallax(INFINITY, 1, kLongest, state);
  ObserveParallax(-1.0, 1, kLongest, state);
  ObserveParallax(1.0, 0, kLongest, state);
  EXPECT_EQ(state.gap, before.gap);
  EXPECT_EQ(state.log_parallax, before.log_parallax);
}

}  // namespace
}  // namespace egosieve::vision
