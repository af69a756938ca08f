#include "vision/trajectory/ground_direction.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace egosieve::vision {
namespace {

using Eigen::Vector3d;

constexpr int kWidth = 480, kHeight = 300;
constexpr double kSeconds = 1.0 / 30.0, kSpeed = 10.0;
const Pinhole kCamera = Pinhole::Of({kWidth, kHeight}, 400.0);
const Vector3d kTravel = Vector3d(0.02, -0.03, -1.0).normalized();

// A road with marks, seen by a camera one height above it that has travelled `way` heights along
// -kTravel and looks 2 degrees beside it.
cv::Mat1b Picture(double way) {
  constexpr int kFiner = 3;
  cv::Mat1b fine(kHeight * kFiner, kWidth * kFiner, uint8_t{150});
  const Vector3d ahead = kTravel / kTravel(2);
  for (int y = 0; y < fine.rows; ++y) {
    for (int x = 0; x < fine.cols; ++x) {
      const Vector3d ray = kCamera.Ray((x + 0.5) / kFiner - 0.5, (y + 0.5) / kFiner - 0.5);
      const double below = ray(1) - ahead(1);
      if (below < 0.01) continue;
      const double across = (ray(0) - ahead(0)) / below;
      const double along = std::fmod(1.0 / below + way, 6.0);
      const bool is_mark = std::abs(std::abs(across) - 1.0) < 0.08 && along < 3.0;
      fine(y, x) = is_mark ? 220 : 90;
    }
  }
  cv::Mat1b picture;
  cv::resize(fine, picture, {kWidth, kHeight}, 0, 0, cv::INTER_AREA);
  return picture;
}

std::vector<GroundSearchView> Views(double speed) {
  std::vector<GroundSearchView> views;
  for (const double from : {0.0, 0.9, 1.7, 2.6, 3.4, 4.3, 5.1}) {
    GroundSearchView& view = views.emplace_back();
    view.camera = kCamera;
    for (int k = 0; k < 6; ++k) {
      view.pictures.push_back({Picture(from + k * speed * kSeconds), k * kSeconds});
    }
  }
  return views;
}

TravelPrior PriorOf(const Vector3d& direction) {
  TravelPrior prior;
  prior.direction = direction.normalized();
  prior.concentration = 400.0;
  prior.share = 0.8;
  return prior;
}

double DegreesBetween(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / M_PI;
}

TEST(GroundDirection, HalvesWhatFlowMissedTheDirectionBy) {
  const TravelPrior prior = PriorOf(kTravel + Vector3d(0.015, 0.02, 0.0));
  const double missed = DegreesBetween(prior.direction, kTravel);
  ASSERT_GT(missed, 1.4);
  EXPECT_LT(DegreesBetween(DirectionByGround(prior, Views(kSpeed)), kTravel), 0.5 * missed);
}

TEST(GroundDirection, StaysWhereNothingMoves) {
  const TravelPrior prior = PriorOf(kTravel + Vector3d(0.015, 0.02, 0.0));
  EXPECT_EQ(DirectionByGround(prior, Views(0.0)), prior.direction);
}

TEST(GroundDirection, StaysWithoutViewsAndSideways) {
  const TravelPrior prior = PriorOf(kTravel);
  EXPECT_EQ(DirectionByGround(prior, {}), prior.direction);
  const TravelPrior sideways = PriorOf(Vector3d::UnitX());
  EXPECT_EQ(DirectionByGround(sideways, Views(kSpeed)), sideways.direction);
}

}  // namespace
}  // namespace egosieve::vision
