// When a plane that a pair of pictures shows counts as the road.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "tests/vision/evidence/road_view.h"
#include "vision/evidence/evidence_accumulator.h"

namespace egosieve::vision {
namespace {

// The view's picture as frame `index`, `world` the motion from the picture before it. tilt: the
// camera is turned by as much, about the line of sight, in both pictures; radians.
EvidenceFrame FrameOf(const View& view, int index, std::optional<Eigen::Vector3d> travel,
                      double tilt = 0.0) {
  EvidenceFrame frame;
  frame.index = index;
  frame.size = kImage;
  frame.camera = view.camera;
  TwoViewMotion motion;
  motion.found = true;
  motion.translation = -Eigen::Vector3d::UnitZ();
  motion.mean_parallax = 0.05;
  motion.noise_pixels = 0.1;
  motion.noise = 0.1 / view.camera.focal_pixels;
  motion.static_share = 0.9;
  motion.moving_scale = 0.02;
  motion.parallax_pixels = 3.0;
  motion.travel = travel;
  frame.world = motion;
  frame.motion_model = MotionModelKind::kFundamental;
  frame.motion_matrix = FundamentalOf(motion, view.camera);
  const auto turned = [&](double x, double y) {
    const double dx = x - view.camera.centre_x, dy = y - view.camera.centre_y;
    return cv::Point2f(
        static_cast<float>(view.camera.centre_x + std::cos(tilt) * dx - std::sin(tilt) * dy),
        static_cast<float>(view.camera.centre_y + std::sin(tilt) * dx + std::cos(tilt) * dy));
  };
  for (const PointPair& pair : view.pairs) {
    EvidencePoint& point = frame.points.emplace_back();
    point.now = turned(pair.x2, pair.y2);
    point.before = turned(pair.x1, pair.y1);
    point.estimates = true;
  }
  return frame;
}

bool SaysOfTheRoad(const EvidenceResult& result) {
  for (const PointEvidence& point : result.points) {
    if (point.present[static_cast<int>(EvidenceTerm::kRoad)]) return true;
  }
  return false;
}

TEST(RoadConfirmation, AnotherPictureConfirmsThePlane) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator = *EvidenceAccumulator::Create({});
  EXPECT_FALSE(SaysOfTheRoad(*accumulator.Add(FrameOf(view, 1, std::nullopt))));
  EXPECT_TRUE(SaysOfTheRoad(*accumulator.Add(FrameOf(view, 2, std::nullopt))));
  EXPECT_TRUE(accumulator.state().road.known);
}

TEST(RoadConfirmation, AnotherPlaneDoesNot) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator = *EvidenceAccumulator::Create({});
  for (int t = 1; t <= 4; ++t) {
    // Six degrees of roll to and fro.
    const double tilt = t % 2 == 0 ? 0.05 : -0.05;
    EXPECT_FALSE(SaysOfTheRoad(*accumulator.Add(FrameOf(view, t, std::nullopt, tilt)))) << t;
    EXPECT_TRUE(accumulator.state().road.proposed);
    EXPECT_FALSE(accumulator.state().road.known);
  }
}

TEST(RoadConfirmation, ASlopeIsRememberedForFiveFramesThatDoNotShowIt) {
  const View view = MakeView(0.05);
  const double steep = 0.3;  // radians of roll, more than a camera on a car has
  for (const int unseen : {5, 6}) {
    EvidenceAccumulator accumulator = *EvidenceAccumulator::Create({});
    int t = 1;
    for (; t <= 2; ++t) ASSERT_TRUE(accumulator.Add(FrameOf(view, t, std::nullopt)).ok());
    for (; t <= 2 + unseen; ++t) {
      EXPECT_FALSE(SaysOfTheRoad(*accumulator.Add(FrameOf(view, t, std::nullopt, steep))));
    }
    EXPECT_EQ(SaysOfTheRoad(*accumulator.Add(FrameOf(view, t, std::nullopt))), unseen == 5);
  }
}

TEST(RoadConfirmation, TheDirectionOfTravelConfirmsALevelPlaneBelowIt) {
  const View view = MakeView(0.05);
  EvidenceAccumulator accumulator = *EvidenceAccumulator::Create({});
  EXPECT_TRUE(SaysOfTheRoad(*accumulator.Add(FrameOf(view, 1, -Eigen::Vector3d::UnitZ()))));
  // Travel three degrees below the plane's horizon.
  EvidenceAccumulator other = *EvidenceAccumulator::Create({});
  const Eigen::Vector3d below = Eigen::Vector3d(0.0, -0.05, -1.0).normalized();
  EXPECT_FALSE(SaysOfTheRoad(*other.Add(FrameOf(view, 1, below))));
}

}  // namespace
}  // namespace egosieve::vision
