#include "vision/evidence/dense_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "gtest/gtest.h"
#include "vision/evidence/epipolar_line.h"
#include "vision/evidence/photometric_support.h"

namespace egosieve::vision {
namespace {

constexpr int kWidth = 161, kHeight = 121, kFocal = 100;
constexpr int kMiddle = 80, kFar = 2, kNear = 5, kNearest = 8;  // pixels that static points move
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

const cv::Rect kMover(16, 30, 30, 24), kBlank(100, 30, 30, 30), kEdge(100, 80, 30, 30);
const cv::Point kMoves(3, 6);

std::shared_ptr<kernels::Context> TestContext() {
  static const auto context = kernels::OpenContext();
  EXPECT_TRUE(context.ok()) << context.status();
  return context.ok() ? *context : nullptr;
}

// The camera moves to the left past two planes, the left one deeper. On the left a square moves on
// its own; on the right a square is blank and one has a single edge.
DenseSweepPair Scene() {
  cv::RNG random(11);
  DenseSweepPair pair;
  pair.before.create(kHeight, kWidth, CV_8UC1);
  random.fill(pair.before, cv::RNG::UNIFORM, 0, 255);
  pair.before(kBlank).setTo(90);
  pair.before(kEdge).setTo(90);
  pair.before(kEdge & cv::Rect(0, 0, 115, kHeight)).setTo(150);
  pair.now.create(kHeight, kWidth, CV_8UC1);
  random.fill(pair.now, cv::RNG::UNIFORM, 0, 255);
  pair.before.colRange(0, kMiddle).copyTo(pair.now.colRange(kFar, kMiddle + kFar));
  pair.before.colRange(kMiddle, kWidth - kNear).copyTo(pair.now.colRange(kMiddle + kNear, kWidth));
  cv::Mat uncovered = pair.now(kMover + cv::Point(kFar, 0));
  random.fill(uncovered, cv::RNG::UNIFORM, 0, 255);
  pair.before(kMover).copyTo(pair.now(kMover + kMoves));
  pair.camera = Pinhole::Of(pair.before.size(), kFocal);
  pair.translation = Eigen::Vector3d::UnitX();
  pair.most_inverse_depth = static_cast<double>(kNearest) / kFocal;
  pair.flow.create((kHeight + 1) / 2, (kWidth + 1) / 2, CV_32FC2);
  for (int row = 0; row < pair.flow.rows; ++row) {
    for (int column = 0; column < pair.flow.cols; ++column) {
      const bool moves = kMover.contains({2 * column, 2 * row});
      const float along = 2 * column < kMiddle ? kFar : kNear;
      pair.flow.at<cv::Vec2f>(row, column) =
          moves ? cv::Vec2f(kMoves.x, kMoves.y) : cv::Vec2f(along, 0.0f);
    }
  }
  return pair;
}

cv::Mat RatiosOf(const DenseSweepPair& pair, const DenseSweepOptions& options = {}) {
  const absl::StatusOr<cv::Mat> ratios = DenseSweepLogRatios(*TestContext(), pair, options);
  EXPECT_TRUE(ratios.ok()) << ratios.status();
  return ratios.ok() ? *ratios : cv::Mat(kHeight, kWidth, CV_32FC1, cv::Scalar(kNan));
}

// The places whose patches lie in the area.
cv::Mat At(const cv::Mat& ratios, const cv::Rect& area) {
  const int left = (area.x + 4) / 2, top = (area.y + 4) / 2;
  return ratios(
      cv::Rect(left, top, (area.br().x - 4) / 2 - left + 1, (area.br().y - 4) / 2 - top + 1));
}

// Static places of both planes, away from the others and from where the mover goes.
const cv::Rect kStandingFar(8, 72, 60, 40), kStandingNear(84, 4, 60, 24);

TEST(DenseSweep, MovingPlacesAreToldFromStaticOnes) {
  const cv::Mat ratios = RatiosOf(Scene());
  double least, most;
  cv::minMaxLoc(At(ratios, kMover), &least, nullptr);
  EXPECT_GT(least, 20.0);
  // Flow found the static position: there is nothing between the two.
  for (const cv::Rect& standing : {kStandingFar, kStandingNear}) {
    cv::minMaxLoc(At(ratios, standing), &least, &most);
    EXPECT_NEAR(least, 0.0, 1e-3);
    EXPECT_NEAR(most, 0.0, 1e-3);
  }
}

TEST(DenseSweep, PlacesThatFlowLosesAreStaticWhereTheStaticWarpExplainsThem) {
  DenseSweepPair pair = Scene();
  pair.flow.setTo(cv::Scalar(kNan, kNan));
  const cv::Mat ratios = RatiosOf(pair);
  double least, most;
  cv::minMaxLoc(At(ratios, kMover), &least, nullptr);
  EXPECT_GT(least, 5.0);
  for (const cv::Rect& standing : {kStandingFar, kStandingNear}) {
    cv::minMaxLoc(At(ratios, standing), nullptr, &most);
    EXPECT_LT(most, -20.0);
  }
}

TEST(DenseSweep, WrongFlowIsEvidenceForStatic) {
  DenseSweepPair pair = Scene();
  pair.flow += cv::Scalar(0, 5);
  const cv::Mat ratios = RatiosOf(pair);
  for (const cv::Rect& standing : {kStandingFar, kStandingNear}) {
    double most;
    cv::minMaxLoc(At(ratios, standing), nullptr, &most);
    EXPECT_LT(most, -20.0);
  }
}

TEST(DenseSweep, BlankPlacesAbstainAndSoDoEdgesThatFlowLoses) {
  DenseSweepPair pair = Scene();
  pair.flow += cv::Scalar(2, 5);
  EXPECT_EQ(cv::countNonZero(At(RatiosOf(pair), kBlank)), 0);
  EXPECT_GT(cv::countNonZero(At(RatiosOf(pair), kEdge)), 0);
  pair.flow.setTo(cv::Scalar(kNan, kNan));
  const cv::Mat lost = RatiosOf(pair);
  EXPECT_EQ(cv::countNonZero(At(lost, kBlank)), 0);
  EXPECT_EQ(cv::countNonZero(At(lost, kEdge)), 0);
}

TEST(DenseSweep, WhatLeavesThePictureAbstains) {
  DenseSweepPair pair = Scene();
  for (const float flow : {1000.0f, kNan}) {
    pair.flow.setTo(cv::Scalar(flow, flow));
    const cv::Mat ratios = RatiosOf(pair);
    ASSERT_EQ(ratios.size(), cv::Size((kWidth + 1) / 2, (kHeight + 1) / 2));
    EXPECT_TRUE(cv::checkRange(ratios));  // no NaN
    EXPECT_EQ(cv::countNonZero(ratios.row(1)), 0);
    EXPECT_EQ(cv::countNonZero(ratios.col(ratios.cols - 2)), 0);
    if (!std::isnan(flow)) {
      EXPECT_EQ(cv::countNonZero(ratios), 0);
    }
  }
}

// (DE1) and (S2) at the same positions. Those of the sweep in float32 are off by less than 3e-4
// pixels (24 u 160), a level thus by 0.15 in x and y. Patches of noise differ by 100 in a pixel, so
// that E_0 is off by 0.3 %, and l + kappa N / 2, which is proportional to it, likewise; E_1 is at
// whole pixels.
TEST(DenseSweep, TheRatioIsThatOfSinglePoints) {
  DenseSweepPair pair = Scene();
  pair.place_pixels = 0.1;
  DenseSweepOptions options;
  options.step_pixels = 0.5;
  ASSERT_EQ(SweepStepsOf(pair, options).size(), 2u * kNearest + 1);
  const cv::Mat ratios = RatiosOf(pair, options);
  const PhotometricSupport support(pair.before, pair.now, {{30, 40}}, {{33, 46}}, 0.1);
  ASSERT_EQ(support.noise_levels(), pair.noise_levels);
  int compared = 0;
  for (int row = 0; row < ratios.rows; ++row) {
    for (int column = 0; column < ratios.cols; ++column) {
      const cv::Point2f place(2.0f * column, 2.0f * row);
      const cv::Vec2f flow = pair.flow.at<cv::Vec2f>(row, column);
      if (!kMover.contains(place)) continue;
      const std::optional<double> single =
          support.LogRatioOnSegment(place, place + cv::Point2f(flow[0], flow[1]),
                                    {place, place + cv::Point2f(kNearest, 0.0f)});
      ASSERT_TRUE(single.has_value());
      const double dense = ratios.at<float>(row, column);
      EXPECT_NEAR(std::max(0.0, dense), *single, 3e-3 * (*single + 0.25 * 49.0 / 2.0)) << place;
      if (dense > 1.0) ++compared;
    }
  }
  EXPECT_GT(compared, 90);
}

TEST(DenseSweep, StepsAreEqualAlongTheLine) {
  DenseSweepPair pair = Scene();
  pair.translation = -Eigen::Vector3d::UnitZ();  // the camera moves ahead
  pair.rotation << 1.0, -0.01, 0.0, 0.01, 1.0, 0.0, 0.0, 0.0, 1.0;
  pair.most_inverse_depth = 0.35;
  const std::vector<kernels::SweepStep> steps = SweepStepsOf(pair, {});
  ASSERT_GT(steps.size(), 30u);
  EXPECT_EQ(steps.front().inverse_depth, 0.0f);
  EXPECT_NEAR(steps.back().inverse_depth, 0.35, 1e-6);
  const EpipolarLine corner = LineOf(pair.camera, pair.rotation, pair.translation, 0, 0);
  const EpipolarLine inside = LineOf(pair.camera, pair.rotation, pair.translation, 60, 40);
  const auto position = [&](const EpipolarLine& line, double r) {
    return line.Along(pair.camera.Project(line.ray + r * pair.translation));
  };
  const double step = position(corner, steps[1].inverse_depth);
  EXPECT_LE(step, 1.0 + 1e-4);
  EXPECT_GT(step, 0.9);
  for (size_t j = 0; j < steps.size(); ++j) {
    const double r = steps[j].inverse_depth, scale = 1.0 / (1.0 - r);
    // Float32 depths: 0.35 of 2^-24 times up to 300 pixels.
    EXPECT_NEAR(position(corner, r), step * static_cast<double>(j), 1e-3);
    EXPECT_LE(position(inside, r), position(corner, r));
    EXPECT_NEAR(steps[j].scale, scale < 1.05 ? 1.0 : scale, 1e-5);
  }
}

TEST(DenseSweep, StepsAreLimited) {
  DenseSweepPair pair = Scene();
  DenseSweepOptions options;
  options.most_steps = 4;
  const std::vector<kernels::SweepStep> few = SweepStepsOf(pair, options);
  ASSERT_EQ(few.size(), 4u);
  EXPECT_NEAR(few[1].inverse_depth, 0.08 / 3.0, 1e-6);
  options.most_steps = 1;
  EXPECT_EQ(SweepStepsOf(pair, options).size(), 1u);
  // The point 1 unit before the camera is never reached: patches grow by 4 at most.
  pair.translation = -Eigen::Vector3d::UnitZ();
  pair.most_inverse_depth = 5.0;
  EXPECT_NEAR(SweepStepsOf(pair, {}).back().scale, 4.0, 1e-4);
  pair.translation.setZero();
  EXPECT_EQ(SweepStepsOf(pair, {}).size(), 1u);
}

TEST(DenseSweep, BadArgumentsAreNamed) {
  const auto expect = [](const char* text, const auto& change) {
    DenseSweepPair pair = Scene();
    DenseSweepOptions options;
    change(pair, options);
    const absl::StatusOr<cv::Mat> ratios = DenseSweepLogRatios(*TestContext(), pair, options);
    EXPECT_EQ(ratios.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(ratios.status().message().find(text), absl::string_view::npos) << ratios.status();
  };
  expect("stride", [](auto&, auto& options) { options.stride = 0; });
  expect("step_pixels", [](auto&, auto& options) { options.step_pixels = NAN; });
  expect("most_steps", [](auto&, auto& options) { options.most_steps = 0; });
  expect("of one size", [](auto& pair, auto&) { pair.now = pair.now.rowRange(1, 9); });
  expect("CV_8UC1", [](auto& pair, auto&) { pair.before.convertTo(pair.before, CV_32FC1); });
  expect("61 rows", [](auto& pair, auto&) { pair.flow = pair.flow.rowRange(1, 9); });
  expect("most_inverse_depth", [](auto& pair, auto&) { pair.most_inverse_depth = INFINITY; });
  expect("noise_levels", [](auto& pair, auto&) { pair.noise_levels = 0.0; });
  expect("place_pixels", [](auto& pair, auto&) { pair.place_pixels = -1.0; });
  expect("homography", [](auto& pair, auto&) { pair.rotation(1, 1) = NAN; });
}

}  // namespace
}  // namespace egosieve::vision
