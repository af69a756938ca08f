#include "vision/evidence/guided_match.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/vision/evidence/road_view.h"

namespace egosieve::vision {
namespace {

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
    return MatchRoad(road, camera, pose, before, now, 2.0, places);
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
    EXPECT_LT(ErrorOf(scene, scene.road.m, place), 1e-3);
  }
}

// What stands on the road, and what moves on it, have another motion.
TEST(GuidedMatch, FindsNothingElse) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  const std::vector<cv::Point2f> places = PlacesBetween(220, 350);
  const cv::Mat wall = scene.Before(now, {0.0, 0.0, 0.6});
  EXPECT_LT(scene.Match(wall, now, places).size(), 0.02 * places.size());
  const cv::Mat moved = scene.Before(now, scene.road.m, {4.0, 0.0});
  EXPECT_LT(scene.Match(moved, now, places).size(), 0.02 * places.size());
}

TEST(GuidedMatch, ThereIsNoRoadAboveTheHorizon) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  EXPECT_TRUE(scene.Match(scene.Before(now, scene.road.m), now, PlacesBetween(20, 170)).empty());
}

TEST(GuidedMatch, BlankPicturesShowNothing) {
  const Scene scene = StraightAhead();
  const cv::Mat grey(kImage, CV_8UC1, cv::Scalar(120));
  EXPECT_TRUE(scene.Match(grey, grey, PlacesBetween(40, 350)).empty());
}

TEST(GuidedMatch, PlacesAtTheBorderAreLeftOut) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  const auto found = scene.Match(scene.Before(now, scene.road.m), now,
                                 {{0, 0}, {639, 359}, {-5, 100}, {320, 359}, {1e9f, 10}});
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace egosieve::vision
