#include "vision/trajectory/two_view_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "gmock/gmock.h"
#include "tests/vision/evidence/point_street.h"

namespace egosieve::vision {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;

double AngleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return std::acos(std::min(1.0, 0.5 * ((a * b.transpose()).trace() - 1.0))) * kDegrees;
}

// Share of the points, moving or not, that are likelier to move.
double MovingShare(const PointStreet& street, int a, int b, const TwoViewMotion& motion,
                   bool moves) {
  std::vector<int64_t> indices;
  const std::vector<PointPair> pairs = street.Pairs(a, b, &indices);
  int count = 0, moving = 0;
  for (size_t k = 0; k < pairs.size(); ++k) {
    if (street.moves(indices[k]) != moves) continue;
    const PairLikelihood likelihood = LikelihoodOf(motion, street.camera(), pairs[k]);
    ++count;
    moving += likelihood.log_moving > likelihood.log_static ? 1 : 0;
  }
  return static_cast<double>(moving) / count;
}

StreetOptions WithMovers(int count, const Eigen::Vector3d& travel) {
  StreetOptions options;
  options.noise_pixels = 0.25;
  options.mover_count = count;
  options.mover_travel = travel;
  return options;
}

TEST(TwoViewMotion, FindsTheCameraOfADriveAmongMovers) {
  const StreetOptions options = WithMovers(150, {0.7, 0.0, 0.4});
  const PointStreet street(options);
  const TwoViewMotion motion = EstimateTwoViewMotion(street.Pairs(0, 2), street.camera(), {});
  ASSERT_TRUE(motion.found);
  EXPECT_TRUE(motion.HasParallax());
  // 0.25 px at a focal length of 720 px is 0.02 degrees for one point.
  EXPECT_LT(AngleBetween(motion.rotation, street.RotationBetween(0, 2)), 0.02);
  const Eigen::Vector3d travel = -(street.RotationBetween(0, 2) * options.travel).normalized();
  EXPECT_LT(std::acos(motion.translation.dot(travel)) * kDegrees, 1.0);
  EXPECT_LT(MovingShare(street, 0, 2, motion, false), 0.01);
  EXPECT_GT(MovingShare(street, 0, 2, motion, true), 0.9);
}

// A camera that only turns is the same model: no translation shows, and what moves is told.
TEST(TwoViewMotion, TurningOnTheSpotLeavesNoParallax) {
  StreetOptions options;
  options.noise_pixels = 0.25;
  options.travel = {0.0, 0.0, 0.0};
  options.yaw = 0.03;
  options.mover_count = 100;
  options.mover_travel = {0.3, 0.05, 0.0};
  const PointStreet street(options);
  const TwoViewMotion motion = EstimateTwoViewMotion(street.Pairs(0, 1), street.camera(), {});
  ASSERT_TRUE(motion.found);
  EXPECT_FALSE(motion.HasParallax());
  EXPECT_LT(AngleBetween(motion.rotation, street.RotationBetween(0, 1)), 0.03);
  EXPECT_LT(MovingShare(street, 0, 1, motion, false), 0.01);
  EXPECT_GT(MovingShare(street, 0, 1, motion, true), 0.9);
}

// A camera that turns behind 45 points of 100 that turn with it, in any order.
TEST(TwoViewMotion, TheLargerPartDecidesHowTheCameraTurns) {
  StreetOptions options;
  options.noise_pixels = 0.25;
  options.travel = {0.0, 0.0, 0.0};
  options.yaw = 0.05;
  const PointStreet street(options);
  std::vector<PointPair> pairs = street.Pairs(0, 1);
  for (size_t k = 0; k < pairs.size() * 45 / 100; ++k) {
    pairs[k].x2 = pairs[k].x1;
    pairs[k].y2 = pairs[k].y1;
  }
  std::mt19937_64 generator(1);
  for (int order = 0; order < 8; ++order) {
    std::shuffle(pairs.begin(), pairs.end(), generator);
    const TwoViewMotion motion = EstimateTwoViewMotion(pairs, street.camera(), {});
    ASSERT_TRUE(motion.found);
    EXPECT_LT(AngleBetween(motion.rotation, street.RotationBetween(0, 1)), 0.1) << order;
  }
}

// What pulls away along the epipolar lines has a negative depth.
TEST(TwoViewMotion, NegativeDepthIsUnlikely) {
  StreetOptions options;
  options.noise_pixels = 0.25;
  options.mover_count = 100;
  options.mover_travel = {0.03, 0.0, 1.5};
  const PointStreet street(options);
  const TwoViewMotion motion = EstimateTwoViewMotion(street.Pairs(0, 3), street.camera(), {});
  ASSERT_TRUE(motion.found);
  EXPECT_GT(MovingShare(street, 0, 3, motion, true), 0.75);
  EXPECT_LT(MovingShare(street, 0, 3, motion, false), 0.01);
}

// Only of a camera on no vehicle may static places lie many deviations off.
TEST(TwoViewMotion, OnAVehicleStaticPlacesDoNotScatter) {
  const PointStreet street(WithMovers(0, {0.0, 0.0, 0.0}));
  const std::vector<PointPair> pairs = street.Pairs(0, 1);
  TwoViewMotionOptions options;
  const TwoViewMotion hand_held = EstimateOnDrive(pairs, street.camera(), options);
  options.travel = {Eigen::Vector3d::UnitZ(), 1000.0, 0.99};
  const TwoViewMotion driven = EstimateOnDrive(pairs, street.camera(), options);
  EXPECT_TRUE(hand_held.scatters);
  EXPECT_FALSE(driven.scatters);
  PointPair off = pairs[0];
  off.x2 += 6.0;
  off.y2 += 6.0;
  const auto ratio = [&](const TwoViewMotion& motion) {
    const PairLikelihood likelihood = LikelihoodOf(motion, street.camera(), off, false);
    return likelihood.log_moving - likelihood.log_static;
  };
  EXPECT_GT(ratio(driven), ratio(hand_held) + 10.0);
}

TEST(TwoViewMotion, InverseIsTheMotionBack) {
  StreetOptions options;
  const PointStreet street(options);
  const TwoViewMotion there = EstimateTwoViewMotion(street.Pairs(0, 2), street.camera(), {});
  const TwoViewMotion back = EstimateTwoViewMotion(street.Pairs(2, 0), street.camera(), {});
  ASSERT_TRUE(there.found && back.found);
  const TwoViewMotion inverse = Inverse(there);
  EXPECT_LT(AngleBetween(inverse.rotation, back.rotation), 0.02);
  EXPECT_GT(inverse.translation.dot(back.translation), std::cos(1.0 / kDegrees));
}

// Traffic that crosses as one body and is nearly half of what is seen is taken for the world,
// unless the drive has said where the camera travels.
TEST(TwoViewMotion, TheDrivesDirectionDecidesWhereTrafficIsTakenForTheWorld) {
  const StreetOptions options = WithMovers(550, {0.8, 0.0, 0.0});
  const PointStreet street(options);
  const Eigen::Vector3d travel = -options.travel.normalized();
  const auto direction = [](const TwoViewMotion& motion) {
    return Eigen::Vector3d(motion.rotation.transpose() * motion.translation);
  };
  TwoViewMotionOptions known;
  const TwoViewMotion alone = EstimateTwoViewMotion(street.Pairs(0, 2), street.camera(), known);
  known.travel.direction = travel;
  known.travel.concentration = 400.0;
  known.travel.share = 0.8;
  const TwoViewMotion told = EstimateTwoViewMotion(street.Pairs(0, 2), street.camera(), known);
  ASSERT_TRUE(alone.found && told.found);
  EXPECT_LT(direction(alone).dot(travel), std::cos(10.0 / kDegrees));
  EXPECT_GT(direction(told).dot(travel), std::cos(3.0 / kDegrees));
}

// What was known to move stays a mover where it fills more than half of the picture. What was
// wrongly taken for one does not hide the world where that is clear.
TEST(TwoViewMotion, WhatMovedBeforeIsNotTakenForTheWorld) {
  StreetOptions options = WithMovers(800, {0.8, 0.0, 0.0});
  const PointStreet street(options);
  std::vector<int64_t> indices;
  const std::vector<PointPair> pairs = street.Pairs(0, 2, &indices);
  std::vector<float> moved;
  for (const int64_t index : indices) moved.push_back(street.moves(index) ? 0.97f : 0.02f);
  const Eigen::Vector3d travel = -options.travel.normalized();
  const auto off = [&](const std::vector<float>& before) {
    const TwoViewMotion motion = EstimateTwoViewMotion(pairs, street.camera(), {}, before);
    EXPECT_TRUE(motion.found);
    const Eigen::Vector3d tau = motion.rotation.transpose() * motion.translation;
    return std::acos(std::clamp(tau.dot(travel), -1.0, 1.0)) * kDegrees;
  };
  EXPECT_GT(off({}), 10.0);
  EXPECT_LT(off(moved), 3.0);
  EXPECT_EQ(off(std::vector<float>(pairs.size(), 0.5f)), off({}));

  options.mover_count = 100;
  const PointStreet clear(options);
  const std::vector<PointPair> few = clear.Pairs(0, 2, &indices);
  moved.clear();
  for (const int64_t index : indices) {
    moved.push_back(!clear.moves(index) && index % 4 == 0 ? 0.97f : 0.02f);
  }
  const TwoViewMotion motion = EstimateTwoViewMotion(few, clear.camera(), {}, moved);
  EXPECT_LT(MovingShare(clear, 0, 2, motion, false), 0.01);
}

// A prior that is wrong does not win against a picture that is clear.
TEST(TwoViewMotion, AWrongDirectionIsOverruled) {
  StreetOptions options;
  options.noise_pixels = 0.25;
  const PointStreet street(options);
  TwoViewMotionOptions wrong;
  wrong.travel.direction = Eigen::Vector3d::UnitX();
  wrong.travel.concentration = 400.0;
  const Eigen::Vector3d travel = -(street.RotationBetween(0, 2) * options.travel).normalized();
  for (const double share : {0.8, 1.0 - 1e-6}) {
    wrong.travel.share = share;
    const TwoViewMotion motion = EstimateTwoViewMotion(street.Pairs(0, 2), street.camera(), wrong);
    ASSERT_TRUE(motion.found);
    EXPECT_LT(std::acos(motion.translation.dot(travel)) * kDegrees, 1.0) << share;
  }
}

TEST(TwoViewMotion, FewPairsGiveNone) {
  const PointStreet street({});
  std::vector<PointPair> pairs = street.Pairs(0, 1);
  pairs.resize(19);
  EXPECT_FALSE(EstimateTwoViewMotion(pairs, street.camera(), {}).found);
  EXPECT_FALSE(EstimateTwoViewMotion({}, street.camera(), {}).found);
}

}  // namespace
}  // namespace egosieve::vision
