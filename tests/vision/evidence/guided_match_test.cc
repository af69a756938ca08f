#include "vision/evidence/guided_match.h"

#include <gtest/gtest.h>

#include <algorithm>
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

  // Where what lies on the plane m, and is seen at (x, y) now, was seen before.
  cv::Point2d Before(const Eigen::Vector3d& m, double x, double y) const {
    const Eigen::Vector3d ray = camera.Ray(x, y);
    const Eigen::Vector3d now = ray / m.dot(ray);
    const Eigen::Vector3d before = pose.rotation.transpose() * (now - pose.translation);
    const Eigen::Vector2d place = camera.Project(before);
    return {place(0), place(1)};
  }
  // What `now` shows, as seen before: all of it on the plane m, and moved by `shift` on its own.
  cv::Mat Before(const cv::Mat& now, const Eigen::Vector3d& m, cv::Point2d shift = {}) const {
    std::vector<cv::Point2f> corners = {{100, 250}, {500, 250}, {500, 340}, {100, 340}}, moved;
    for (const cv::Point2f at : corners) moved.emplace_back(Before(m, at.x, at.y) + shift);
    cv::Mat before;
    cv::warpPerspective(now, before, cv::getPerspectiveTransform(corners, moved), kImage,
                        cv::INTER_CUBIC, cv::BORDER_REFLECT);
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

TEST(GuidedMatch, FindsTheRoad) {
  const Scene scene = StraightAhead();
  const cv::Mat now = Texture();
  const std::vector<cv::Point2f> places = PlacesBetween(220, 350);
  const auto found = scene.Match(scene.Before(now, scene.road.m), now, places);
  EXPECT_GT(found.size(), 0.95 * places.size());
  for (const GuidedPlace& place : found) {
    const cv::Point2d before = scene.Before(scene.road.m, place.now.x, place.now.y);
    EXPECT_NEAR(place.before.x, before.x, 1e-3);
    EXPECT_NEAR(place.before.y, before.y, 1e-3);
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

TEST(GuidedMatch, BlankRoadCountsUpToWhatStandsOnIt) {
  const Scene scene = StraightAhead();
  const std::vector<cv::Point2f> places = PlacesBetween(220, 350);
  const cv::Mat blank(kImage, CV_8UC1, cv::Scalar(120));
  EXPECT_EQ(scene.Match(blank, blank, places).size(), places.size());

  // A bumper, as far in both pictures as a car ahead at equal speed, and blank above it.
  cv::Mat car = blank.clone();
  const cv::Rect bumper(200, 280, 200, 20);
  Texture()(bumper).copyTo(car(bumper));
  const auto found = scene.Match(car, car, places);
  EXPECT_LT(found.size(), places.size());
  for (const GuidedPlace& place : found) {
    const bool is_above = place.now.x > 205 && place.now.x < 395 && place.now.y < 295;
    EXPECT_FALSE(is_above) << place.now;
  }
  const auto beside = std::count_if(found.begin(), found.end(), [](const GuidedPlace& place) {
    return place.now.x < 190 || place.now.x > 410;
  });
  EXPECT_GT(beside, 300);
}

// Its edge alone moves as the road does, along which it looks the same.
TEST(GuidedMatch, ABlankDoorAboveAStraightEdgeIsNotTheRoad) {
  const Scene scene = StraightAhead();
  const cv::Rect door(200, 0, 200, 285);
  cv::Mat now(kImage, CV_8UC1, cv::Scalar(120));
  now(door).setTo(160);
  const auto found = scene.Match(scene.Before(now, scene.road.m), now, PlacesBetween(220, 350));
  int below = 0;
  for (const GuidedPlace& place : found) {
    const bool is_in_its_columns = place.now.x > door.x + 15 && place.now.x < door.br().x - 15;
    if (!is_in_its_columns) continue;
    EXPECT_GT(place.now.y, door.br().y - 4) << place.now;
    ++below;
  }
  EXPECT_EQ(below, 6 * 17);  // all of them
}

TEST(GuidedMatch, BlankRoadMayGrowBrighterSlowly) {
  const Scene scene = StraightAhead();
  cv::Mat now(kImage, CV_8UC1);
  for (int y = 0; y < now.rows; ++y) now.row(y).setTo(60 + y / 2);
  const std::vector<cv::Point2f> places = PlacesBetween(220, 350);
  EXPECT_EQ(scene.Match(scene.Before(now, scene.road.m), now, places).size(), places.size());
}

TEST(GuidedMatch, WhatGrewDarkIsNotTheRoad) {
  const Scene scene = StraightAhead();
  const cv::Mat before(kImage, CV_8UC1, cv::Scalar(120)), now(kImage, CV_8UC1, cv::Scalar(90));
  EXPECT_TRUE(scene.Match(before, now, PlacesBetween(220, 350)).empty());
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
