#include "vision/evidence/guided_match.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/vision/evidence/road_view.h"

namespace egosieve::vision {
namespace {

constexpr double kWall = 0.12;  // r of a wall ahead

cv::Mat Texture() {
  cv::Mat picture(kImage, CV_8UC1);
  cv::RNG random(7);
  random.fill(picture, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(picture, picture, {}, 2.0);
  cv::normalize(picture, picture, 0, 255, cv::NORM_MINMAX);
  return picture;
}

struct Scene {
  Pinhole camera = Pinhole::Of(kImage, 420);
  RelativePose pose;
  RoadPlane road;

  // now to before, of the plane m.
  Eigen::Matrix3d MotionOf(const Eigen::Vector3d& m) const {
    const RelativePose back = Inverse(pose);
    const Eigen::Matrix3d k = camera.Matrix();
    return k * (back.rotation + back.translation * m.transpose()) * k.inverse();
  }
  // What `now` shows, as seen before: all of it on the plane m, and moved by `shift` on its own.
  cv::Mat Before(const cv::Mat& now, const Eigen::Vector3d& m, cv::Point2d shift = {}) const {
    const Eigen::Matrix3d motion = MotionOf(m);
    cv::Mat matrix(3, 3, CV_64F), before;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        matrix.at<double>(row, column) = motion(row, column);
    }
    const cv::Mat own = (cv::Mat_<double>(3, 3) << 1, 0, shift.x, 0, 1, shift.y, 0, 0, 1);
    cv::warpPerspective(now, before, own * matrix, kImage, cv::INTER_CUBIC, cv::BORDER_REFLECT);
    return before;
  }
  std::vector<GuidedPlace> Match(const cv::Mat& before, const cv::Mat& now,
                                 const std::vector<cv::Point2f>& places) const {
    return GuidedMatcher(before, now, camera, pose, road, 2.0).Match(places);
  }
};

Scene StraightAhead() {
  Scene scene;
  scene.pose.outcome = PoseOutcome::kFound;
  scene.pose.translation = -Eigen::Vector3d::UnitZ();
  scene.pose.rotation = RotationOf({0.004, -0.01, 0.003});
  scene.road.found = true;
  scene.road.m = {0.0, kTravel / kHeight, 0.0};
  return scene;
}

std::vector<cv::Point2f> PlacesBetween(int top, int bottom) {
  std::vector<cv::Point2f> places;
  for (int y = top; y < bottom; y += 10) {
    for (int x = 60; x < kImage.width - 60; x += 10) {
      places.emplace_back(static_cast<float>(x), static_cast<float>(y));
    }
  }
  return places;
}

const Eigen::Vector3d kWallPlane(0.0, 0.0, kWall);

double ErrorOf(const Scene& scene, const Eigen::Vector3d& m, const GuidedPlace& place) {
  const Eigen::Vector3d at = scene.MotionOf(m) * Eigen::Vector3d(place.now.x, place.now.y, 1.0);
  return std::hypot(place.before.x - at(0) / at(2), place.before.y - at(1) / at(2));
}

TEST(GuidedMatch, FindsTheRoad) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  const std::vector<cv::Point2f> places = PlacesBetween(220, 350);
  const auto found = scene.Match(scene.Before(now, scene.road.m), now, places);
  EXPECT_GT(found.size(), 0.95 * places.size());
  for (const GuidedPlace& place : found) {
    EXPECT_TRUE(place.is_road && place.has_depth);
    EXPECT_LT(ErrorOf(scene, scene.road.m, place), 1e-3);
  }
}

TEST(GuidedMatch, FindsWhatStandsOnItAlongTheLine) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  const std::vector<cv::Point2f> places = PlacesBetween(40, 160);
  const auto found = scene.Match(scene.Before(now, kWallPlane), now, places);
  EXPECT_GT(found.size(), 0.95 * places.size());
  int with_depth = 0, right = 0;
  for (const GuidedPlace& place : found) {
    EXPECT_FALSE(place.is_road);
    with_depth += place.has_depth;
    right += ErrorOf(scene, kWallPlane, place) < 0.5;
  }
  EXPECT_GT(with_depth, 0.9 * static_cast<double>(places.size()));
  EXPECT_GT(right, 0.9 * static_cast<double>(places.size()));
}

// 12 pixels across the lines: what is found there is found by chance.
TEST(GuidedMatch, DoesNotFindWhatMovesAcrossTheLine) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  const std::vector<cv::Point2f> left_and_right = PlacesBetween(150, 190);
  const auto found = scene.Match(scene.Before(now, kWallPlane, {0.0, 12.0}), now, left_and_right);
  EXPECT_LT(found.size(), 0.1 * left_and_right.size());
}

TEST(GuidedMatch, BlankPicturesShowNothing) {
  const Scene scene = StraightAhead();
  const cv::Mat grey(kImage, CV_8UC1, cv::Scalar(120));
  EXPECT_TRUE(scene.Match(grey, grey, PlacesBetween(40, 350)).empty());
}

TEST(GuidedMatch, DepthIsNotKnownWhereTheTextureRepeats) {
  Scene scene = StraightAhead();
  scene.pose.rotation.setIdentity();
  scene.pose.translation = -Eigen::Vector3d::UnitX();  // lines are rows
  cv::Mat now(kImage, CV_8UC1);
  for (int y = 0; y < now.rows; ++y) {
    for (int x = 0; x < now.cols; ++x) {
      now.at<uint8_t>(y, x) = static_cast<uint8_t>(128 + 60 * std::sin(x * 0.7) * std::cos(y));
    }
  }
  const auto found = scene.Match(scene.Before(now, kWallPlane), now, PlacesBetween(40, 160));
  ASSERT_GT(found.size(), 50u);
  for (const GuidedPlace& place : found) EXPECT_FALSE(place.has_depth);
}

TEST(GuidedMatch, PlacesAtTheBorderAreLeftOut) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  const auto found = scene.Match(scene.Before(now, kWallPlane), now,
                                 {{0, 0}, {639, 359}, {-5, 100}, {320, 359}, {1e9f, 10}});
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace egosieve::vision
