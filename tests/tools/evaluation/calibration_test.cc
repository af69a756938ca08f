#include "tools/evaluation/calibration.h"

#include <gtest/gtest.h>

#include <cmath>

namespace egosieve::tools {
namespace {

TEST(CalibrationTest, ByHand) {
  // 13107 is a stated probability of exactly 0.2, 52428 of 0.8.
  RocHistogram scores;
  for (int i = 0; i < 5; ++i) scores.Add(13107, i == 0);  // 1 of 5: as stated
  for (int i = 0; i < 5; ++i) scores.Add(52428, i < 2);   // 2 of 5: stated too high by 0.4
  const Calibration calibration = *CalibrationOf(scores, 10);
  const double tolerance = 1e-15;
  EXPECT_NEAR(calibration.brier, (0.64 + 4 * 0.04 + 2 * 0.04 + 3 * 0.64) / 10, tolerance);
  EXPECT_NEAR(calibration.log_loss,
              -(std::log(0.2) + 4 * std::log(0.8) + 2 * std::log(0.8) + 3 * std::log(0.2)) / 10,
              4 * tolerance);
  EXPECT_NEAR(calibration.expected_calibration_error, 0.5 * 0.0 + 0.5 * 0.4, tolerance);
  EXPECT_EQ(calibration.bins[2].pixels + calibration.bins[1].pixels, 5);
  EXPECT_EQ(calibration.bins[9].pixels, 0);
}

TEST(CalibrationTest, CertainlyRightCostsLittleAndCertainlyWrongStaysFinite) {
  RocHistogram right, wrong;
  right.Add(65535, true);
  right.Add(0, false);
  wrong.Add(0, true);
  EXPECT_NEAR(CalibrationOf(right)->log_loss, 0.5 / 65535, 1e-9);
  EXPECT_EQ(CalibrationOf(right)->brier, 0.0);
  EXPECT_NEAR(CalibrationOf(wrong)->log_loss, std::log(2 * 65535.0), 1e-9);
  EXPECT_EQ(CalibrationOf(right)->bins.back().pixels, 1);  // the last bin is closed
}

TEST(CalibrationTest, NoFigureFromNothing) {
  EXPECT_FALSE(CalibrationOf(RocHistogram()).has_value());
}

}  // namespace
}  // namespace egosieve::tools
