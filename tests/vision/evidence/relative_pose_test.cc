#include "vision/evidence/relative_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/vision/evidence/point_street.h"

namespace egosieve::vision {
namespace {

double AngleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a * b.transpose()).angle();
}
double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

TEST(RelativePose, ExactPointsGiveTheExactPose) {
  const PointStreet street(StreetOptions{});
  const RelativePose pose =
      EstimateRelativePose(street.Pairs(0, 1), street.Fundamental(0, 1), street.camera(), {});
  ASSERT_EQ(pose.outcome, PoseOutcome::kFound);
  // Rounding of F and of the places, 1e-16, times their condition, about 1e4.
  EXPECT_LT(AngleBetween(pose.rotation, street.RotationBetween(0, 1)), 1e-10);
  EXPECT_LT(AngleBetween(pose.translation, street.TranslationBetween(0, 1)), 1e-8);
}

TEST(RelativePose, SidewaysAndReversingHaveTheRightSign) {
  for (const Eigen::Vector3d& travel :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(0, 0, -1)}) {
    StreetOptions options;
    options.travel = travel;
    const PointStreet street(options);
    const RelativePose pose =
        EstimateRelativePose(street.Pairs(0, 1), street.Fundamental(0, 1), street.camera(), {});
    ASSERT_EQ(pose.outcome, PoseOutcome::kFound);
    EXPECT_LT(AngleBetween(pose.translation, street.TranslationBetween(0, 1)), 1e-8);
  }
}

TEST(RelativePose, SharpTurns) {
  for (const double yaw : {-0.3, 0.15}) {  // of a view of 0.9 radians
    StreetOptions options;
    options.yaw = yaw;
    options.static_count = 2000;
    const PointStreet street(options);
    const RelativePose pose =
        EstimateRelativePose(street.Pairs(0, 1), street.Fundamental(0, 1), street.camera(), {});
    ASSERT_EQ(pose.outcome, PoseOutcome::kFound) << yaw;
    EXPECT_LT(AngleBetween(pose.rotation, street.RotationBetween(0, 1)), 1e-8);
    EXPECT_LT(AngleBetween(pose.translation, street.TranslationBetween(0, 1)), 1e-6);
  }
}

// The fit must repair a fundamental matrix that is off.
TEST(RelativePose, NoisyPointsStayWithinTheStatedCovariance) {
  double squares = 0.0;
  const int trials = 40;
  for (int trial = 0; trial < trials; ++trial) {
    StreetOptions options;
    options.noise_pixels = 0.3;
    options.seed = 100 + trial;
    const PointStreet street(options);
    Eigen::Matrix3d f = street.Fundamental(0, 3);
    f(0, 1) *= 1.01;
    const RelativePose pose = EstimateRelativePose(street.Pairs(0, 3), f, street.camera(), {});
    ASSERT_EQ(pose.outcome, PoseOutcome::kFound);
    const Eigen::AngleAxisd error(street.RotationBetween(0, 3) * pose.rotation.transpose());
    const Eigen::Vector3d w = error.angle() * error.axis();
    squares += w.dot(pose.rotation_covariance.inverse() * w);
    // The deviation of some 300 numbers: 4 %, five times that allowed.
    EXPECT_NEAR(pose.noise_pixels, 0.3, 0.06);
  }
  // The mean of 40 chi-squares of 3 degrees is 3 +- 0.39; robust weights cost up to a factor of
  // two.
  EXPECT_GT(squares / trials, 3.0 - 5 * 0.39);
  EXPECT_LT(squares / trials, 2 * 3.0 + 5 * 0.39);
}

// A quarter of the points pulls away along lines that are nearly epipolar, with residuals of 0 to 3
// pixels: (P6) keeps them from bending the pose.
TEST(RelativePose, CarsThatPullAwayDoNotBendThePose) {
  for (int trial = 0; trial < 20; ++trial) {
    StreetOptions options;
    options.noise_pixels = 0.3;
    options.mover_count = 120;
    options.seed = 200 + trial;
    const PointStreet street(options);
    const RelativePose pose =
        EstimateRelativePose(street.Pairs(0, 3), street.Fundamental(0, 3), street.camera(), {});
    ASSERT_EQ(pose.outcome, PoseOutcome::kFound);
    // The noise of 300 points gives the rotation to 0.3 / 720 / sqrt(300) x 5 (the translation's
    // part) = 1e-4; the movers alone would turn it by a pixel, 1.4e-3.
    EXPECT_LT(AngleBetween(pose.rotation, street.RotationBetween(0, 3)), 7e-4) << trial;
  }
}

TEST(RelativePose, NoTranslationIsSaid) {
  StreetOptions options;
  options.travel.setZero();
  options.noise_pixels = 0.2;
  options.yaw = 0.05;
  const PointStreet street(options);
  const RelativePose pose = EstimateRelativePose(
      street.Pairs(0, 1), FundamentalOfInventedTravel(options, {0.1, 0.0, 1.0}), street.camera(),
      {});
  EXPECT_EQ(pose.outcome, PoseOutcome::kNoTranslation);
}

// What a rotation looks like through another lens is no rotation; nor is it travel.
TEST(RelativePose, NoTranslationIsSaidUnderAGuessedLens) {
  StreetOptions options;
  options.travel.setZero();
  options.noise_pixels = 0.1;
  options.yaw = 0.15;
  const PointStreet street(options);
  const Eigen::Matrix3d fundamental = FundamentalOfInventedTravel(options, {0.1, 0.0, 1.0});
  for (const double share : {0.45, 0.9}) {  // 0.58 is the true one
    const Pinhole guess = Pinhole::Of(options.size, share * options.size.width);
    const RelativePose pose = EstimateRelativePose(street.Pairs(0, 1), fundamental, guess, {});
    EXPECT_EQ(pose.outcome, PoseOutcome::kNoTranslation) << share << Name(pose.outcome);
    const RelativePose certain =
        EstimateRelativePose(street.Pairs(0, 1), fundamental, guess, {.lens_multiple = 0});
    EXPECT_NE(certain.outcome, PoseOutcome::kNoTranslation) << share;
  }
}

TEST(RelativePose, DegenerateInputIsAnOutcome) {
  const PointStreet street(StreetOptions{});
  const Eigen::Matrix3d f = street.Fundamental(0, 1);
  const Pinhole& camera = street.camera();
  EXPECT_EQ(EstimateRelativePose({}, f, camera, {}).outcome, PoseOutcome::kUndetermined);
  EXPECT_EQ(EstimateRelativePose(street.Pairs(0, 1), Eigen::Matrix3d::Zero(), camera, {}).outcome,
            PoseOutcome::kUndetermined);
  EXPECT_EQ(
      EstimateRelativePose(street.Pairs(0, 1), Eigen::Matrix3d::Constant(std::nan("")), camera, {})
          .outcome,
      PoseOutcome::kUndetermined);
  const std::vector<PointPair> one_place(100, PointPair{10, 10, 10, 10});
  EXPECT_FALSE(EstimateRelativePose(one_place, f, camera, {}).found());
  std::mt19937_64 random(5);
  std::vector<PointPair> noise(500);
  for (PointPair& pair : noise) {
    for (double* value : {&pair.x1, &pair.y1, &pair.x2, &pair.y2}) {
      *value = static_cast<double>(random() % 1000);
    }
  }
  EXPECT_FALSE(EstimateRelativePose(noise, f, camera, {}).found());
}

TEST(RelativePose, InverseTakesPointsBack) {
  const PointStreet street(StreetOptions{});
  const RelativePose pose =
      EstimateRelativePose(street.Pairs(0, 1), street.Fundamental(0, 1), street.camera(), {});
  const RelativePose back = Inverse(pose);
  const Eigen::Vector3d x(1, -2, 9);
  const Eigen::Vector3d there = pose.rotation * x + pose.translation;
  EXPECT_LT((back.rotation * there + back.translation - x).norm(), 1e-12);
}

TEST(RelativePose, OptionsAreChecked) {
  RelativePoseOptions options;
  EXPECT_TRUE(options.Validate().ok());
  options.parallax_share = std::nan("");
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.cheirality_margin = 0.3;
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.max_pairs = 3;
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.focal_deviation = std::nan("");
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.lens_multiple = -1;
  EXPECT_FALSE(options.Validate().ok());
}

}  // namespace
}  // namespace egosieve::vision
