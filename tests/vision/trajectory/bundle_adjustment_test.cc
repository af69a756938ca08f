#include "vision/trajectory/bundle_adjustment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/vision/evidence/point_street.h"

namespace egosieve::vision {
namespace {

constexpr int kPictures = 6;

// Of the first frames of a street.
TrackWindow WindowOf(const PointStreet& street) {
  TrackWindow window;
  window.pictures = kPictures;
  for (int64_t i = 0; i < street.size(); ++i) {
    std::vector<cv::Point2d> track;
    for (int k = 0; k < kPictures; ++k) {
      const Eigen::Vector2d place = street.Place(i, k);
      if (!street.Inside(place)) break;
      track.emplace_back(place(0), place(1));
    }
    if (track.size() >= 3) window.tracks.push_back(track);
  }
  return window;
}

std::vector<TrackWindow> WindowsOf(const StreetOptions& options) {
  std::vector<TrackWindow> windows;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    StreetOptions changed = options;
    changed.seed = seed;
    windows.push_back(WindowOf(PointStreet(changed)));
  }
  return windows;
}

StreetOptions Turning(double focal) {
  StreetOptions options;
  options.size = {800, 600};
  options.focal_pixels = focal;
  options.static_count = 300;
  options.yaw = 0.03;
  options.pitch = 0.01;
  options.noise_pixels = 0.2;
  options.travel = {0.0, 0.0, 0.2};
  return options;
}

// The noise is independent here, so the errors are smaller than what a window that counts as 30
// observations lets expect.
void ExpectWithinDeviation(const AdjustedLens& lens, double ratio) {
  EXPECT_LT(std::abs(std::log(lens.focal_ratio / ratio)), lens.log_focal_deviation);
}

TEST(BundleAdjustment, TurnsTellTheFocalLength) {
  for (const double focal : {400.0, 560.0, 1400.0}) {
    const AdjustedLens lens = AdjustLens(WindowsOf(Turning(focal)), {800, 600});
    ExpectWithinDeviation(lens, focal / 800);
    EXPECT_EQ(lens.windows, 4);
    EXPECT_LT(lens.log_focal_deviation, 0.05) << focal;
    EXPECT_NEAR(lens.noise_pixels, 0.2, 0.05) << focal;
  }
}

TEST(BundleAdjustment, ACameraThatOnlyTurnsTellsTheFocalLength) {
  StreetOptions options = Turning(560.0);
  options.travel.setZero();
  const AdjustedLens lens = AdjustLens(WindowsOf(options), {800, 600});
  ExpectWithinDeviation(lens, 560.0 / 800);
  EXPECT_LT(lens.log_focal_deviation, 0.1);
}

TEST(BundleAdjustment, MoversAreOutliers) {
  StreetOptions options = Turning(560.0);
  options.mover_count = 100;
  options.mover_travel = {0.3, 0.0, 0.5};
  ExpectWithinDeviation(AdjustLens(WindowsOf(options), {800, 600}), 560.0 / 800);
}

TEST(BundleAdjustment, ADriveStraightAheadIsNotCertain) {
  StreetOptions options = Turning(560.0);
  options.yaw = options.pitch = 0.0;
  options.travel = {0.0, 0.0, 0.5};
  EXPECT_GT(AdjustLens(WindowsOf(options), {800, 600}).log_focal_deviation, 0.2);
}

TEST(BundleAdjustment, WithoutPlacesThePriorHolds) {
  for (const AdjustedLens& lens :
       {AdjustLens({}, {640, 480}), AdjustLens({TrackWindow{4, {}}}, {640, 480})}) {
    EXPECT_EQ(lens.windows, 0);
    EXPECT_EQ(lens.focal_ratio, 0.7);
  }
  // Nothing moves.
  TrackWindow still{4, {}};
  for (int i = 0; i < 100; ++i) {
    still.tracks.emplace_back(4, cv::Point2d(37.0 * i - 640.0 * (37 * i / 640), 4.0 * i + 20.0));
  }
  const AdjustedLens lens = AdjustLens({still}, {640, 480});
  EXPECT_NEAR(lens.focal_ratio, 0.7, 0.07);
  // That of the prior's curvature, 0.4 sqrt(3 / 4).
  EXPECT_NEAR(lens.log_focal_deviation, 0.346, 0.001);
}

// Its last picture would have no pose.
TEST(BundleAdjustment, AWindowThatNoTrackCrossesIsLeftOut) {
  std::vector<TrackWindow> windows = WindowsOf(Turning(560.0));
  const AdjustedLens without = AdjustLens(windows, {800, 600});
  windows.push_back(windows[0]);
  for (auto& track : windows.back().tracks) track.resize(std::min<size_t>(track.size(), 3));
  ASSERT_GT(windows.back().pictures, 3);
  const AdjustedLens with = AdjustLens(windows, {800, 600});
  EXPECT_EQ(with.windows, without.windows);
  EXPECT_EQ(with.focal_ratio, without.focal_ratio);
}

TEST(BundleAdjustment, GivesTheSameBitsAgain) {
  const std::vector<TrackWindow> windows = WindowsOf(Turning(560.0));
  const AdjustedLens first = AdjustLens(windows, {800, 600});
  // Other addresses.
  const std::vector<std::vector<double>> held(50, std::vector<double>(1000));
  const AdjustedLens second = AdjustLens(std::vector<TrackWindow>(windows), {800, 600});
  EXPECT_EQ(first.focal_ratio, second.focal_ratio);
  EXPECT_EQ(first.log_focal_deviation, second.log_focal_deviation);
}

}  // namespace
}  // namespace egosieve::vision
