#include "vision/matching/motion_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace egosieve::vision {
namespace {

constexpr int kCell = MotionField::kCellPixels;
const cv::Size kSize(10 * kCell, 6 * kCell - 7);  // the last row of cells is cut

// A pair every 8 pixels that moves by `of` pixels a picture, `gap` pictures apart.
template <typename Velocity>
std::vector<PointPair> Pairs(int gap, const Velocity& of) {
  std::vector<PointPair> pairs;
  for (int y = 0; y < kSize.height; y += 8) {
    for (int x = 0; x < kSize.width; x += 8) {
      const cv::Point2d v = of(x, y);
      // (MF1) has the velocity where the thing is one picture later.
      pairs.push_back({x - v.x, y - v.y, x + (gap - 1) * v.x, y + (gap - 1) * v.y});
    }
  }
  return pairs;
}

TEST(MotionField, AConstantVelocityGoesOnForAnyNumberOfPictures) {
  const cv::Point2d v(3.5, -2.0);
  for (const int gap : {1, 3}) {
    const MotionField field = MakeMotionField(Pairs(gap, [&](int, int) { return v; }), gap, kSize);
    ASSERT_EQ(field.columns, 10);
    ASSERT_EQ(field.rows, 6);
    for (const int pictures : {1, 2, 5}) {
      const std::vector<cv::Point2f> places = {{0, 0}, {100, 50}, {319, 180}, {500, -40}};
      const auto predicted = PredictPlaces(field, places, pictures);
      ASSERT_EQ(predicted.size(), places.size());
      for (size_t i = 0; i < places.size(); ++i) {
        // Places are float: their rounding at 500 is 3e-5.
        EXPECT_NEAR(predicted[i].x, places[i].x + pictures * v.x, 1e-3);
        EXPECT_NEAR(predicted[i].y, places[i].y + pictures * v.y, 1e-3);
      }
    }
  }
}

// An expansion is linear in the place: between the centres of cells nothing is lost, and the
// median of a cell is its centre's but for the pitch of the pairs.
TEST(MotionField, FollowsAnExpansion) {
  const auto of = [](double x, double y) {
    return cv::Point2d(0.05 * (x - kSize.width / 2), 0.05 * (y - kSize.height / 2));
  };
  const MotionField field = MakeMotionField(Pairs(1, of), 1, kSize);
  for (const cv::Point2f& place :
       {cv::Point2f(40, 30), cv::Point2f(160, 90), cv::Point2f(280, 140)}) {
    const cv::Point2f moved = PredictPlaces(field, {place}, 1)[0] - place;
    EXPECT_NEAR(moved.x, of(place.x, place.y).x, 0.05 * 8);
    EXPECT_NEAR(moved.y, of(place.x, place.y).y, 0.05 * 8);
  }
}

TEST(MotionField, AMinorityOfFalseMatchesDoesNotMoveIt) {
  std::vector<PointPair> pairs = Pairs(1, [](int, int) { return cv::Point2d(5, 1); });
  for (size_t i = 0; i < pairs.size(); i += 3) {
    // They end where they did, so that they lie in the same cells.
    pairs[i].x1 = std::fmod(37.0 * static_cast<double>(i), kSize.width);
    pairs[i].y1 = std::fmod(91.0 * static_cast<double>(i), kSize.height);
  }
  const MotionField field = MakeMotionField(pairs, 1, kSize);
  for (const cv::Point2f& velocity : field.velocities) {
    EXPECT_NEAR(velocity.x, 5, 1e-3);
    EXPECT_NEAR(velocity.y, 1, 1e-3);
  }
}

TEST(MotionField, CellsWithoutMatchesTakeTheirNeighbours) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < 3; ++i) pairs.push_back({10.0 + i, 10, 14.0 + i, 9});
  const MotionField field = MakeMotionField(pairs, 1, kSize);
  ASSERT_EQ(field.velocities.size(), 60u);
  for (const cv::Point2f& velocity : field.velocities) EXPECT_EQ(velocity, cv::Point2f(4, -1));
}

TEST(MotionField, TooLittleIsNoField) {
  EXPECT_TRUE(MakeMotionField({}, 1, kSize).empty());
  EXPECT_TRUE(MakeMotionField({{10, 10, 14, 9}, {11, 10, 15, 9}}, 1, kSize).empty());
  const std::vector<PointPair> nonsense(50, {NAN, 10, 14, INFINITY});
  EXPECT_TRUE(MakeMotionField(nonsense, 1, kSize).empty());
  // Places outside belong to the cell at the border.
  const std::vector<PointPair> outside(50, {-1e300, 1e300, -1e300, 1e300});
  const MotionField field = MakeMotionField(outside, 1, kSize);
  EXPECT_EQ(PredictPlaces(field, {{3, 3}}, 1)[0], cv::Point2f(3, 3));
}

}  // namespace
}  // namespace egosieve::vision
