#include "vision/evidence/relative_pose.h"

#include <Eigen/Geometry>
#include <cmath>

#include "gtest/gtest.h"
#include "tests/vision/evidence/point_street.h"
#include "vision/evidence/negative_depth.h"

namespace egosieve::vision {
namespace {

RelativePose PoseOf(const PointStreet& street, int a, int b, const Pinhole& camera,
                    const RelativePoseOptions& options = {}) {
  return EstimateRelativePose(street.Pairs(a, b), street.Fundamental(a, b), camera, options);
}

double AngleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a * b.transpose()).angle();
}
double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Also sideways, in reverse, and in turns that are sharp for a view of 0.9 radians.
TEST(RelativePose, ExactPointsGiveTheExactPose) {
  const StreetOptions usual;
  for (const auto& [travel, yaw] :
       {std::pair(usual.travel, usual.yaw), std::pair(Eigen::Vector3d(1, 0, 0), usual.yaw),
        std::pair(Eigen::Vector3d(-1, 0, 0), usual.yaw),
        std::pair(Eigen::Vector3d(0, 0, -1), usual.yaw), std::pair(usual.travel, -0.3),
        std::pair(usual.travel, 0.15)}) {
    StreetOptions options{.travel = travel, .yaw = yaw};
    if (std::abs(yaw) > 0.1) options.static_count = 2000;
    const PointStreet street(options);
    const RelativePose pose = PoseOf(street, 0, 1, street.camera());
    ASSERT_EQ(pose.outcome, PoseOutcome::kFound) << travel << yaw;
    // Rounding of F and of the places, 1e-16, times their condition, about 1e4; more in turns.
    const double most = std::abs(yaw) > 0.1 ? 100.0 : 1.0;
    EXPECT_LT(AngleBetween(pose.rotation, street.RotationBetween(0, 1)), most * 1e-10);
    EXPECT_LT(AngleBetween(pose.translation, street.TranslationBetween(0, 1)), most * 1e-8);
  }
}

// The fit must repair a fundamental matrix that is off.
TEST(RelativePose, NoisyPointsStayWithinTheStatedCovariance) {
  double squares = 0.0;
  const int trials = 40;
  for (int trial = 0; trial < trials; ++trial) {
    const PointStreet street({.noise_pixels = 0.3, .seed = 100u + trial});
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
    const PointStreet street({.mover_count = 120, .noise_pixels = 0.3, .seed = 200u + trial});
    const RelativePose pose = PoseOf(street, 0, 3, street.camera());
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
  const RelativePose pose = PoseOf(street, 0, 1, street.camera());
  const RelativePose back = Inverse(pose);
  const Eigen::Vector3d x(1, -2, 9);
  const Eigen::Vector3d there = pose.rotation * x + pose.translation;
  EXPECT_LT((back.rotation * there + back.translation - x).norm(), 1e-12);
}

TEST(RelativePose, OptionsAreChecked) {
  EXPECT_TRUE(RelativePoseOptions().Validate().ok());
  EXPECT_FALSE(RelativePoseOptions{.parallax_share = std::nan("")}.Validate().ok());
  EXPECT_FALSE(RelativePoseOptions{.cheirality_margin = 0.3}.Validate().ok());
  EXPECT_FALSE(RelativePoseOptions{.max_pairs = 3}.Validate().ok());
  EXPECT_FALSE(RelativePoseOptions{.focal_deviation = std::nan("")}.Validate().ok());
  EXPECT_FALSE(RelativePoseOptions{.lens_multiple = -1}.Validate().ok());
}

// Points straight ahead that travel with the camera, faster than it: the epipolar line is blind to
// them, the sign of depth is not.
TEST(NegativeDepth, SeesCarsThatPullAwayAndNoStaticPoint) {
  StreetOptions options{.mover_count = 100, .noise_pixels = 0.25};
  options.mover_travel = {0.03, 0.0, 1.5};  // 1.5 times the camera's travel
  const PointStreet street(options);
  const RelativePose pose = PoseOf(street, 0, 3, street.camera());
  ASSERT_TRUE(pose.found());
  std::vector<int64_t> indices;
  const std::vector<PointPair> pairs = street.Pairs(0, 3, &indices);
  int movers = 0, seen = 0, statics = 0, mistaken = 0;
  for (size_t k = 0; k < pairs.size(); ++k) {
    const SignedFlow flow = MeasureSignedFlow(street.camera(), pose, pairs[k]);
    if (!flow.present) continue;
    const bool negative = flow.along_pixels < -3 * flow.deviation_pixels;
    if (street.moves(indices[k])) {
      ++movers;
      seen += negative ? 1 : 0;
      EXPECT_LT(flow.along_pixels, 3 * flow.deviation_pixels);
    } else {
      ++statics;
      mistaken += negative ? 1 : 0;
    }
  }
  ASSERT_GT(movers, 80);
  ASSERT_GT(statics, 300);
  // Near the image's middle the flow is below the noise: 1.5 m at 20 m is 7 % of the distance to
  // it, more than 3 deviations beyond 20 pixels.
  EXPECT_GT(seen, 0.85 * movers);
  EXPECT_LE(mistaken, 0.005 * statics);
}

TEST(NegativeDepth, DeviationIsThatOfTheNoise) {
  // Points at infinity: s is nothing but noise and the error of the rotation.
  const PointStreet street({.static_count = 1500, .noise_pixels = 0.4});
  const RelativePose pose = PoseOf(street, 0, 2, street.camera(), {.focal_deviation = 0});
  ASSERT_TRUE(pose.found());
  const Eigen::Matrix3d turn = street.RotationBetween(0, 2);
  std::mt19937_64 random(3);
  const auto noise = [&] {
    double sum = -6.0;
    for (int n = 0; n < 12; ++n) sum += static_cast<double>(random() >> 11) * 0x1p-53;
    return 0.4 * sum;
  };
  double squares = 0.0;
  int count = 0;
  for (int k = 0; k < 2000; ++k) {
    const double x = static_cast<double>(random() % 1200), y = static_cast<double>(random() % 370);
    const Eigen::Vector2d far = street.camera().Project(turn * street.camera().Ray(x, y));
    const SignedFlow flow = MeasureSignedFlow(
        street.camera(), pose, {x + noise(), y + noise(), far(0) + noise(), far(1) + noise()});
    if (!flow.present) continue;
    squares += std::pow(flow.along_pixels / flow.deviation_pixels, 2);
    ++count;
  }
  ASSERT_GT(count, 1900);
  // The rotation's error is common to all points, hence the wide bounds; sigma itself is 10 % off.
  EXPECT_GT(squares / count, 0.6);
  EXPECT_LT(squares / count, 1.6);
}

TEST(NegativeDepth, HardlyDependsOnTheFocalLength) {
  StreetOptions options{.mover_count = 80, .mover_travel = {0.03, 0.0, 1.6}, .noise_pixels = 0.2};
  const PointStreet street(options);
  std::vector<int64_t> indices;
  const std::vector<PointPair> pairs = street.Pairs(0, 3, &indices);
  const RelativePose truth = PoseOf(street, 0, 3, street.camera());
  for (const double share : {0.45, 0.7, 0.9, 1.2}) {
    const Pinhole guess = Pinhole::Of(options.size, share * options.size.width);
    const RelativePose pose = PoseOf(street, 0, 3, guess);
    ASSERT_TRUE(pose.found()) << share;
    int changed = 0;
    for (const PointPair& pair : pairs) {
      const SignedFlow a = MeasureSignedFlow(street.camera(), truth, pair);
      const SignedFlow b = MeasureSignedFlow(guess, pose, pair);
      if (!a.present || !b.present) continue;
      const auto negative = [](const SignedFlow& flow) {
        return flow.along_pixels < -3 * flow.deviation_pixels;
      };
      changed += negative(a) != negative(b) ? 1 : 0;
    }
    EXPECT_LT(changed, 0.02 * pairs.size()) << share;
  }
}

StreetOptions SharpTurn() { return {.static_count = 3000, .travel = {0.02, 0.0, 0.5}, .yaw = 0.1}; }

// (P7), (N4): what another focal length makes of the signed flow, the pose estimated anew.
TEST(NegativeDepth, DeviationByTheLensIsTheSlope) {
  const PointStreet street(SharpTurn());
  constexpr double kStep = 0.01, kDeviation = 10.0;
  const double focal = street.camera().focal_pixels;
  const Pinhole longer = Pinhole::Of(SharpTurn().size, focal * std::exp(kStep));
  const Pinhole shorter = Pinhole::Of(SharpTurn().size, focal * std::exp(-kStep));
  const RelativePose at_longer = PoseOf(street, 0, 1, longer),
                     at_shorter = PoseOf(street, 0, 1, shorter),
                     pose = PoseOf(street, 0, 1, street.camera(),
                                   {.lens_multiple = 0, .focal_deviation = kDeviation});
  int compared = 0;
  for (const PointPair& pair : street.Pairs(0, 1)) {
    const SignedFlow a = MeasureSignedFlow(shorter, at_shorter, pair),
                     b = MeasureSignedFlow(longer, at_longer, pair),
                     flow = MeasureSignedFlow(street.camera(), pose, pair);
    // Near the point of expansion lines turn by more than the slope knows.
    if (!a.present || !b.present || !flow.present || a.direction.dot(b.direction) < 0.999) continue;
    const double slope = (b.along_pixels - a.along_pixels) / (2 * kStep);
    const double stated = flow.deviation_pixels / kDeviation;
    EXPECT_NEAR(std::abs(slope), stated, 0.05 * stated + 0.2) << pair.x1 << " " << pair.y1;
    ++compared;
  }
  EXPECT_GT(compared, 500);
}

// The true share is 0.58: guesses up to 1.4 deviations off.
TEST(NegativeDepth, SharpTurnsUnderAGuessedLensPutNoStaticPointBehindTheCamera) {
  StreetOptions options = SharpTurn();
  options.noise_pixels = 0.2;
  const PointStreet street(options);
  for (const double share : {0.45, 0.7, 0.9, 1.0}) {
    const Pinhole guess = Pinhole::Of(options.size, share * options.size.width);
    const RelativePose pose = PoseOf(street, 0, 1, guess, {.lens_multiple = 0});
    ASSERT_TRUE(pose.found()) << share;
    int present = 0, negative = 0;
    for (const PointPair& pair : street.Pairs(0, 1)) {
      const SignedFlow flow = MeasureSignedFlow(guess, pose, pair);
      present += flow.present ? 1 : 0;
      negative += flow.present && flow.along_pixels < -3 * flow.deviation_pixels ? 1 : 0;
    }
    EXPECT_LE(negative, 0.01 * present) << share << ", of " << present;
  }
}

TEST(NegativeDepth, ReversingTurnsTheSign) {
  const PointStreet street(
      {.mover_count = 60, .travel = {0.0, 0.0, -1.0}, .mover_travel = {0.0, 0.0, -1.6}});
  const RelativePose pose = PoseOf(street, 0, 2, street.camera());
  ASSERT_TRUE(pose.found());
  std::vector<int64_t> indices;
  const std::vector<PointPair> pairs = street.Pairs(0, 2, &indices);
  for (size_t k = 0; k < pairs.size(); ++k) {
    const SignedFlow flow = MeasureSignedFlow(street.camera(), pose, pairs[k]);
    if (!flow.present) continue;
    // Places are exact: signs are exact.
    EXPECT_EQ(flow.along_pixels > 0, !street.moves(indices[k])) << k;
  }
}

TEST(NegativeDepth, AbsentWithoutTranslation) {
  StreetOptions options;
  options.travel.setZero();
  options.yaw = 0.02;
  options.noise_pixels = 0.2;
  const PointStreet street(options);
  const RelativePose pose = EstimateRelativePose(
      street.Pairs(0, 1), FundamentalOfInventedTravel(options, {0.0, 0.0, 1.0}), street.camera(),
      {});
  for (const PointPair& pair : street.Pairs(0, 1)) {
    EXPECT_FALSE(MeasureSignedFlow(street.camera(), pose, pair).present);
  }
}

TEST(NegativeDepth, AbsentForPlacesThatAreNone) {
  const PointStreet street(StreetOptions{});
  const RelativePose pose = PoseOf(street, 0, 1, street.camera());
  ASSERT_TRUE(pose.found());
  const double nan = std::nan("");
  EXPECT_FALSE(MeasureSignedFlow(street.camera(), pose, {nan, 1, 2, 3}).present);
  EXPECT_FALSE(MeasureSignedFlow(street.camera(), pose, {1, 2, nan, 3}).present);
}

}  // namespace
}  // namespace egosieve::vision
