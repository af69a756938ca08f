#include "kernels/ops/plane_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/reference/plane_sweep.h"
#include "tests/kernels/test_data.h"

namespace egosieve::kernels {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr double kRoundoff = 1.0 / (1 << 24);  // u

struct Grey {
  Grey(int width, int height, int padding = 0)
      : width(width), height(height), stride(width + padding) {
    pixels.resize(static_cast<size_t>(stride) * height);
  }
  ImageView view() const { return {pixels.data(), width, height, 1, stride}; }
  uint8_t& at(int x, int y) { return pixels[y * stride + x]; }
  uint8_t at(int x, int y) const { return pixels[y * stride + x]; }
  // Greatest difference of neighbours.
  double slope() const {
    int most = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (x > 0) most = std::max(most, std::abs(at(x, y) - at(x - 1, y)));
        if (y > 0) most = std::max(most, std::abs(at(x, y) - at(x, y - 1)));
      }
    }
    return most;
  }
  int width, height, stride;
  std::vector<uint8_t> pixels;
};

Grey Noise(std::mt19937_64& random, int width, int height, int padding = 0) {
  Grey grey(width, height, padding);
  for (uint8_t& pixel : grey.pixels) pixel = static_cast<uint8_t>(random());
  return grey;
}

// Means of 3 x 3 pixels.
Grey SmoothNoise(std::mt19937_64& random, int width, int height, int padding) {
  const Grey noise = Noise(random, width + 2, height + 2);
  Grey grey(width, height, padding);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      int sum = 0;
      for (int i = 0; i < 9; ++i) sum += noise.at(x + i % 3, y + i / 3);
      grey.at(x, y) = static_cast<uint8_t>(sum / 9);
    }
  }
  return grey;
}

// The places at which H = 1 and e = (1, 0, 0) lead `w` pixels to the right.
PlaneSweepInputs Sideways(const Grey& first, const Grey& second, int stride,
                          const std::vector<float>& inverse_depths, std::vector<float>& flow) {
  PlaneSweepInputs inputs;
  inputs.first = first.view();
  inputs.second = second.view();
  inputs.grid = {first.width, first.height, stride};
  inputs.homography = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  inputs.epipole = {1, 0, 0};
  for (const float w : inverse_depths) inputs.steps.push_back({w, 1.0f});
  flow.resize(inputs.grid.size() * 2, 0.0f);
  inputs.flow = {flow.data(), inputs.grid.size(), 2};
  return inputs;
}

using Results = GuardedMatrix<float>;

// The pixel of place i.
std::pair<int, int> PixelOf(const ImageGrid& grid, int64_t i) {
  return {grid.x_pixels(static_cast<int>(i % grid.columns())),
          grid.y_pixels(static_cast<int>(i / grid.columns()))};
}

Results Sweep(Context& context, const PlaneSweepInputs& inputs) {
  Results out(inputs.grid.size(), kSweepColumns, 3);
  const absl::Status status = PlaneSweep(context, inputs, out.view());
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_TRUE(out.guards_intact());
  return out;
}

Results Expected(const PlaneSweepInputs& inputs) {
  Results out(inputs.grid.size(), kSweepColumns);
  reference::PlaneSweep(inputs, out.view());
  return out;
}

// Whether float32 may find a patch around (x, y) on the other side of the picture's border.
bool IsAtBorder(const ImageGrid& grid, double x, double y, double reach) {
  constexpr double kPixels = 1e-3;
  return std::abs(x - reach) < kPixels || std::abs(x + reach - (grid.width - 1)) < kPixels ||
         std::abs(y - reach) < kPixels || std::abs(y + reach - (grid.height - 1)) < kPixels;
}

bool IsAnyAtBorder(const PlaneSweepInputs& inputs, int x, int y) {
  for (const SweepStep& step : inputs.steps) {
    double at[3];
    for (int i = 0; i < 3; ++i) {
      const double* h = &inputs.homography[3 * i];
      at[i] = h[0] * x + h[1] * y + h[2] + step.inverse_depth * inputs.epipole[i];
    }
    const double reach = step.scale * inputs.patch_radius;
    if (IsAtBorder(inputs.grid, at[0] / at[2], at[1] / at[2], reach)) return true;
  }
  return false;
}

// Of a cost. For pictures of at most 101 pixels, z in [0.8, 1.2] and |w e| of at most 10 pixels the
// terms of y sum to at most 128: the coefficients' roundings and three sums are an error of 5 u 128
// of y and as much, relative, of z, the quotient's of 5 u 101, the patch's of 3 u 101. Over z this
// is less than 24 u 128 pixels. Levels are off by that times the slope in x and in y, and by 6 u
// 255 for their interpolation: `level`. Sums of N squares below 255^2 have an error of 16 u.
double CostTolerance(const PlaneSweepInputs& inputs, double slope, double cost) {
  const double n = std::pow(2 * inputs.patch_radius + 1, 2);
  const double level = (2 * 24 * 128 * slope + 6 * 255) * kRoundoff;
  return 2 * std::sqrt(n * cost) * level + n * level * level + 16 * kRoundoff * n * 255 * 255;
}

void ExpectNearOrBothNan(float actual, float expected, double tolerance) {
  if (std::isnan(expected)) {
    EXPECT_TRUE(std::isnan(actual)) << actual;
  } else {
    EXPECT_NEAR(actual, expected, tolerance);
  }
}

// Returns the number of places whose static cost was compared.
int ExpectSame(const PlaneSweepInputs& inputs, double slope, const Results& actual) {
  const ImageGrid& grid = inputs.grid;
  const Results expected = Expected(inputs);
  std::vector<Results> of_step;  // each step alone
  for (const SweepStep& step : inputs.steps) {
    PlaneSweepInputs alone = inputs;
    alone.steps = {step};
    of_step.push_back(Expected(alone));
  }
  int compared = 0;
  for (int64_t i = 0; i < grid.size(); ++i) {
    const auto [x, y] = PixelOf(grid, i);
    SCOPED_TRACE(testing::Message() << "place (" << x << ", " << y << ")");
    if (!IsAtBorder(grid, x + double{inputs.flow(i, 0)}, y + double{inputs.flow(i, 1)},
                    inputs.patch_radius)) {
      ExpectNearOrBothNan(actual(i, kFlowCost), expected(i, kFlowCost),
                          CostTolerance(inputs, slope, expected(i, kFlowCost)));
    }
    // No interpolation: the sums alone.
    ExpectNearOrBothNan(actual(i, kEnergy), expected(i, kEnergy),
                        CostTolerance(inputs, 0.0, expected(i, kEnergy)));
    const double rounding = 32 * kRoundoff * expected(i, kGradient);
    ExpectNearOrBothNan(actual(i, kGradient), expected(i, kGradient), rounding);
    ExpectNearOrBothNan(actual(i, kLeastGradient), expected(i, kLeastGradient), rounding);
    if (IsAnyAtBorder(inputs, x, y)) continue;
    const float cost = expected(i, kStaticCost);
    ExpectNearOrBothNan(actual(i, kStaticCost), cost, CostTolerance(inputs, slope, cost));
    const float j = actual(i, kStaticStep);
    EXPECT_EQ(std::isnan(j), std::isnan(cost));
    if (std::isnan(j) || std::isnan(cost)) continue;
    // Of two equal costs either may be the least.
    const float at_step = of_step[static_cast<size_t>(j)](i, kStaticCost);
    EXPECT_NEAR(at_step, cost, 2.0 * CostTolerance(inputs, slope, at_step));
    ++compared;
  }
  return compared;
}

TEST(PlaneSweep, AgreesWithTheReferenceForEveryShape) {
  std::mt19937_64 random = TestRandom();
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 30}, {8, 8}, {33, 26}, {67, 41}}) {
    const Grey first = SmoothNoise(random, width, height, 5);
    const Grey second = SmoothNoise(random, width, height, 0);
    for (const int stride : {1, 2, 5}) {
      for (const int radius : {1, 2, 3}) {
        for (const int steps : {1, 6}) {
          SCOPED_TRACE(testing::Message() << width << " x " << height << ", stride " << stride
                                          << ", radius " << radius << ", " << steps << " steps");
          PlaneSweepInputs inputs;
          inputs.first = first.view();
          inputs.second = second.view();
          inputs.grid = {width, height, stride};
          inputs.patch_radius = radius;
          // A small turn and roll, a step ahead.
          inputs.homography = {0.999, -0.02, 1.7, 0.02, 0.999, -1.3, 2e-4, -1e-4, 1.0};
          inputs.epipole = {-5.0, 3.0, -0.15};
          for (int j = 0; j < steps; ++j) {
            inputs.steps.push_back(
                {0.2f * static_cast<float>(j), j % 2 == 0 ? 1.0f : 1.0f + 0.1f * j});
          }
          GuardedMatrix<float> flow(inputs.grid.size(), 2, 1);
          for (int64_t i = 0; i < inputs.grid.size(); ++i) {
            flow.view()(i, 0) = i % 7 == 0 ? kNan : static_cast<float>(Uniform(random, -6, 6));
            flow.view()(i, 1) = i % 11 == 0 ? 1e30f : static_cast<float>(Uniform(random, -6, 6));
          }
          inputs.flow = flow.view();
          const double slope = second.slope();
          const int compared = ExpectSame(inputs, slope, Sweep(*TestContext(), inputs));
          ExpectSame(inputs, slope, Sweep(*SideBySideContext(), inputs));
          if (width > 30) {
            const double inside = (width - 2.0 * radius) * (height - 2.0 * radius);
            EXPECT_GT(compared, 0.7 * inside / (stride * stride) - 20);
          }
        }
      }
    }
  }
}

// The left half lies twice as deep as the right one; a square of 24 pixels moves on its own.
TEST(PlaneSweep, StaticPlacesFitOnTheirLineAndMovingOnesDoNot) {
  constexpr int kWidth = 121, kHeight = 80, kMiddle = 60, kFar = 2, kNear = 4;
  constexpr int kLeft = 20, kTop = 30, kSide = 24, kRight = 3, kDown = 6;
  std::mt19937_64 random = TestRandom();
  const Grey first = Noise(random, kWidth, kHeight);
  Grey second = Noise(random, kWidth, kHeight);
  const auto moves = [&](int x, int y) {
    return x >= kLeft && x < kLeft + kSide && y >= kTop && y < kTop + kSide;
  };
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x + kNear < kWidth; ++x) {
      if (!moves(x, y)) second.at(x + (x < kMiddle ? kFar : kNear), y) = first.at(x, y);
    }
  }
  for (int y = kTop; y < kTop + kSide; ++y) {
    for (int x = kLeft; x < kLeft + kSide; ++x) second.at(x + kRight, y + kDown) = first.at(x, y);
  }
  std::vector<float> flow;
  const PlaneSweepInputs inputs = Sideways(first, second, 2, {0, 1, 2, 3, 4, 5, 6}, flow);
  const ImageGrid& grid = inputs.grid;
  for (int64_t i = 0; i < grid.size(); ++i) {
    const auto [x, y] = PixelOf(grid, i);
    flow[2 * i] = moves(x, y) ? kRight : (x < kMiddle ? kFar : kNear);
    flow[2 * i + 1] = moves(x, y) ? kDown : 0.0f;
  }
  const Results out = Sweep(*TestContext(), inputs);
  int of_static = 0, of_moving = 0;
  for (int64_t i = 0; i < grid.size(); ++i) {
    const auto [x, y] = PixelOf(grid, i);
    SCOPED_TRACE(testing::Message() << "place (" << x << ", " << y << ")");
    const bool is_beside = y + 3 < kTop || y - 3 >= kTop + kSide + kDown;
    const bool is_inside = x >= 3 && y >= 3 && x + kNear + 3 < kWidth - 1 && y + 3 < kHeight - 1;
    if (moves(x - 3, y - 3) && moves(x + 3, y + 3)) {
      EXPECT_EQ(out(i, kFlowCost), 0.0f);
      EXPECT_GT(out(i, kStaticCost), 0.5f * out(i, kEnergy));
      ++of_moving;
    } else if (is_beside && is_inside && (x + 3 < kMiddle - 2 || x - 3 >= kMiddle)) {
      EXPECT_EQ(out(i, kFlowCost), 0.0f);
      EXPECT_EQ(out(i, kStaticCost), 0.0f);
      EXPECT_EQ(out(i, kStaticStep), x < kMiddle ? kFar : kNear);
      ++of_static;
    }
  }
  EXPECT_GT(of_moving, 60);
  EXPECT_GT(of_static, 800);
}

TEST(PlaneSweep, TextureTellsBlankPlacesAndEdges) {
  constexpr int kSide = 30;
  Grey picture(kSide, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) picture.at(x, y) = x < 20 ? 90 : 150;
  }
  std::vector<float> flow;
  const PlaneSweepInputs inputs = Sideways(picture, picture, 1, {0, 1}, flow);
  const Results out = Sweep(*TestContext(), inputs);
  const int64_t blank = 12 * kSide + 10, edge = 12 * kSide + 20;
  for (const SweepColumn column : {kStaticCost, kFlowCost, kEnergy, kGradient, kLeastGradient}) {
    EXPECT_EQ(out(blank, column), 0.0f) << column;
  }
  // 3 of 7 columns are dark: N 3/7 4/7 60^2. Of 5 inner columns two have a gradient of 30. Both
  // within the error of the sums.
  EXPECT_NEAR(out(edge, kEnergy), 49.0 * 12.0 / 49.0 * 3600.0, CostTolerance(inputs, 0, 0));
  EXPECT_NEAR(out(edge, kGradient), 2.0 / 5.0 * 900.0, 32 * kRoundoff * 360);
  EXPECT_NEAR(out(edge, kLeastGradient), 0.0, 32 * kRoundoff * 360);
}

TEST(PlaneSweep, BrightnessThatChangesEverywhereIsNoDifference) {
  std::mt19937_64 random = TestRandom();
  Grey first = Noise(random, 30, 20);
  for (uint8_t& pixel : first.pixels) pixel = static_cast<uint8_t>(pixel % 128);
  Grey second = first;
  for (uint8_t& pixel : second.pixels) pixel = static_cast<uint8_t>(pixel + 100);
  std::vector<float> flow;
  const PlaneSweepInputs inputs = Sideways(first, second, 2, {0}, flow);
  const Results out = Sweep(*TestContext(), inputs);
  const int64_t place = 5 * inputs.grid.columns() + 5;
  EXPECT_NEAR(out(place, kStaticCost), 0.0, CostTolerance(inputs, 0, 0));
  EXPECT_GT(out(place, kEnergy), 49.0 * 500.0);
}

// The second picture shows everything at twice its size.
TEST(PlaneSweep, APatchIsComparedAtItsScale) {
  std::mt19937_64 random = TestRandom();
  const Grey first = Noise(random, 40, 30);
  Grey second(40, 30);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) second.at(x, y) = first.at(x / 2, y / 2);
  }
  std::vector<float> flow;
  PlaneSweepInputs inputs = Sideways(first, second, 1, {0}, flow);
  const double free = 1e60;  // the scale of (SW1), beyond the range of float32
  inputs.homography = {2 * free, 0, 0, 0, 2 * free, 0, 0, 0, free};
  inputs.steps = {{0.0f, 1.0f}, {0.0f, 2.0f}};
  const Results out = Sweep(*TestContext(), inputs);
  for (const auto& [x, y] : {std::pair{3, 3}, {8, 9}, {16, 11}}) {
    EXPECT_EQ(out(y * 40 + x, kStaticCost), 0.0f);
    EXPECT_EQ(out(y * 40 + x, kStaticStep), 1.0f);
  }
  // 2 * 17 + 2 * 3 is beyond the last column but one; at the scale 1 it is not.
  EXPECT_EQ(out(9 * 40 + 17, kStaticStep), 0.0f);
}

TEST(PlaneSweep, WhatLeavesThePicturesIsNotANumber) {
  constexpr int kWidth = 31, kHeight = 21;
  std::mt19937_64 random = TestRandom();
  const Grey first = Noise(random, kWidth, kHeight), second = Noise(random, kWidth, kHeight);
  std::vector<float> flow;
  PlaneSweepInputs inputs = Sideways(first, second, 1, {0, 8, 16}, flow);
  const auto at = [&](int x, int y) { return static_cast<int64_t>(y) * kWidth + x; };
  flow[2 * at(10, 10)] = kNan;
  flow[2 * at(11, 10) + 1] = 7.5f;
  const Results out = Sweep(*TestContext(), inputs);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool inside = x >= 3 && y >= 3 && x + 3 < kWidth - 1 && y + 3 < kHeight - 1;
      for (const SweepColumn column : {kStaticCost, kStaticStep, kEnergy, kGradient}) {
        ASSERT_EQ(std::isnan(out(at(x, y), column)), !inside) << x << ", " << y << ": " << column;
      }
      // From the last column for which it is still inside.
      if (inside && x + 8 + 3 >= kWidth - 1) {
        ASSERT_EQ(out(at(x, y), kStaticStep), 0.0f) << x << ", " << y;
      }
    }
  }
  EXPECT_TRUE(std::isnan(out(at(10, 10), kFlowCost)));
  EXPECT_TRUE(std::isnan(out(at(11, 10), kFlowCost)));
  EXPECT_FALSE(std::isnan(out(at(12, 10), kFlowCost)));
  inputs.steps = {{40.0f, 1.0f}};
  EXPECT_TRUE(std::isnan(Sweep(*TestContext(), inputs)(at(12, 10), kStaticCost)));
  // Behind the camera: y_3 is not positive.
  inputs.steps = {{1.0f, 1.0f}};
  inputs.epipole = {-30.0, -20.0, -2.0};
  const Results behind = Sweep(*TestContext(), inputs);
  EXPECT_TRUE(std::isnan(behind(at(12, 10), kStaticCost)));
  EXPECT_TRUE(std::isnan(behind(at(12, 10), kStaticStep)));
  EXPECT_FALSE(std::isnan(behind(at(12, 10), kFlowCost)));
}

TEST(PlaneSweep, BadArgumentsAreNamedAndNothingIsWritten) {
  std::mt19937_64 random = TestRandom();
  const Grey first = Noise(random, 30, 20), second = Noise(random, 30, 20);
  const Grey other = Noise(random, 30, 21);
  std::vector<float> flow;
  const PlaneSweepInputs good = Sideways(first, second, 2, {0, 1}, flow);
  Results out(good.grid.size(), kSweepColumns);
  const auto message_of = [&](const auto& change) {
    PlaneSweepInputs bad = good;
    change(bad);
    const absl::Status status = PlaneSweep(*TestContext(), bad, out.view());
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_TRUE(out.untouched());
    return std::string(status.message());
  };
  const auto expect = [&](const char* text, const auto& change) {
    const std::string message = message_of(change);
    EXPECT_NE(message.find(text), std::string::npos) << message;
  };
  using Inputs = PlaneSweepInputs;
  expect("stride = 0", [](Inputs& bad) { bad.grid.stride = 0; });
  expect("second has 30 x 21", [&](Inputs& bad) { bad.second = other.view(); });
  expect("first has 30 x 20 pixels of 3", [](Inputs& bad) { bad.first.channels = 3; });
  expect("29 bytes a row", [](Inputs& bad) { bad.first.stride_bytes = 29; });
  expect("without data", [](Inputs& bad) { bad.first.data = nullptr; });
  expect("homography(1, 2)", [](Inputs& bad) { bad.homography[5] = NAN; });
  expect("epipole(0, 2)", [](Inputs& bad) { bad.epipole[2] = INFINITY; });
  expect("steps are empty", [](Inputs& bad) { bad.steps.clear(); });
  expect("steps[1]", [](Inputs& bad) { bad.steps[1].scale = 0.0f; });
  expect("steps[0]", [](Inputs& bad) { bad.steps[0].inverse_depth = kNan; });
  expect("flow", [](Inputs& bad) { --bad.flow.rows; });
  expect("patch_radius", [](Inputs& bad) { bad.patch_radius = 0; });
  expect("patch_radius", [](Inputs& bad) { bad.patch_radius = 4; });
  Results narrow(good.grid.size(), kSweepColumns - 1);
  EXPECT_FALSE(PlaneSweep(*TestContext(), good, narrow.view()).ok());
  EXPECT_TRUE(narrow.untouched());
}

}  // namespace
}  // namespace egosieve::kernels
