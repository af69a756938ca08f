#include "vision/evidence/foot_search.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/vision/evidence/road_view.h"

namespace egosieve::vision {
namespace {

constexpr double kNoise = 2.0;           // grey levels
constexpr int kTop = -40, kBottom = 20;  // of a search, rows from the true foot

cv::Mat Texture(int seed) {
  cv::Mat picture(kImage, CV_8UC1);
  cv::RNG random(seed);
  random.fill(picture, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(picture, picture, {}, 1.5);
  cv::normalize(picture, picture, 20, 235, cv::NORM_MINMAX);
  return picture;
}

cv::Mat WithNoise(const cv::Mat& picture, int seed) {
  cv::Mat noise(picture.size(), CV_16S), sum;
  cv::RNG random(seed);
  random.fill(noise, cv::RNG::NORMAL, 0, kNoise);
  cv::add(picture, noise, sum, cv::noArray(), CV_8U);
  return sum;
}

// A road and, above the row of its foot, an object of one inverse depth.
class Scene {
 public:
  Scene() {
    pose_.outcome = PoseOutcome::kFound;
    pose_.translation = -Eigen::Vector3d::UnitZ();
    pose_.rotation = RotationOf({0.004, -0.01, 0.003});
    road_.found = true;
    road_.m = {0.0, kTravel / kHeight, 0.0};
  }

  double RoadAt(double row) const { return road_.At(camera_.Ray(0.0, row)); }
  void Render(int foot, double inverse_depth) {
    const cv::Mat road = Texture(1), object = Texture(2);
    cv::Mat is_object(kImage, CV_8UC1, cv::Scalar(0)), now = road.clone();
    is_object.rowRange(0, foot).setTo(255);
    object.copyTo(now, is_object);
    cv::Mat before = Before(road, road_.m);
    const Eigen::Vector3d m(0.0, 0.0, inverse_depth);
    Before(object, m).copyTo(before, Before(is_object, m) > 127);
    now_ = WithNoise(now, 3);
    before_ = WithNoise(before, 4);
  }
  void RenderBlank() { before_ = now_ = cv::Mat(kImage, CV_8UC1, cv::Scalar(120)); }
  double FootRow(cv::Point2f top, cv::Point2f bottom, double inverse_depth) const {
    const FootSearch feet(road_, camera_, pose_, before_, now_, kNoise);
    return camera_.Project(feet.LowestFoot(top, bottom, inverse_depth))(1);
  }

  // Of columns all over the picture, for what is nearer by a factor than the road at its foot.
  std::vector<double> FootRows(int foot, double nearer) {
    const double r = nearer * RoadAt(foot);
    Render(foot, r);
    std::vector<double> rows;
    for (float x = 40.0f; x < 600.0f; x += 20.0f) {
      rows.push_back(FootRow({x, foot + float{kTop}}, {x, foot + float{kBottom}}, r));
    }
    return rows;
  }

 private:
  // What `now` shows, as seen before: all of it on the plane m.
  cv::Mat Before(const cv::Mat& now, const Eigen::Vector3d& m) const {
    const RelativePose back = Inverse(pose_);
    const Eigen::Matrix3d k = camera_.Matrix();
    const Eigen::Matrix3d h = k * (back.rotation + back.translation * m.transpose()) * k.inverse();
    cv::Matx33d motion;
    for (int i = 0; i < 9; ++i) motion(i / 3, i % 3) = h(i / 3, i % 3);
    cv::Mat before;
    cv::warpPerspective(now, before, motion, kImage, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    return before;
  }

  Pinhole camera_ = Pinhole::Of(kImage, 420);
  RelativePose pose_;
  RoadPlane road_;
  cv::Mat before_, now_;
};

TEST(FootSearch, FindsTheFootOfWhatIsTooNear) {
  Scene scene;
  int count = 0, near = 0;
  for (const int foot : {240, 290}) {
    for (const double nearer : {1.4, 1.6, 2.0}) {
      for (const double row : scene.FootRows(foot, nearer)) {
        EXPECT_NEAR(scene.RoadAt(row) / scene.RoadAt(foot), 1.0, 0.05) << nearer;
        ++count;
        near += row > foot - 1.5;
      }
    }
  }
  EXPECT_GT(near, 0.95 * count);
}

// At its foot it moves as the road does. A twentieth of r is a third of what road_contact.h allows.
TEST(FootSearch, WhatStandsHasItsFootHardlyHigherThanItIs) {
  Scene scene;
  for (const int foot : {240, 290}) {
    for (const double row : scene.FootRows(foot, 1.0)) {
      EXPECT_GT(scene.RoadAt(row), 0.95 * scene.RoadAt(foot));
    }
  }
}

// The road right below its foot was hidden by it.
TEST(FootSearch, NorHasWhatIsTooFar) {
  Scene scene;
  for (const int foot : {240, 290}) {
    for (const double nearer : {0.0, 0.5}) {
      for (const double row : scene.FootRows(foot, nearer)) EXPECT_GT(row, foot - 2.5) << nearer;
    }
  }
}

TEST(FootSearch, RowsBeyondThePictureSayNothing) {
  Scene scene;
  constexpr int kFoot = 240;
  const double r = 2.0 * scene.RoadAt(kFoot);
  scene.Render(kFoot, r);
  EXPECT_NEAR(scene.FootRow({200.0f, -8.0f}, {200.0f, kFoot + kBottom}, r), kFoot + 0.5, 1.5);
}

TEST(FootSearch, ItIsTheBottomWherePicturesDoNotTell) {
  Scene scene;
  constexpr float kFoot = 240.0f;
  const double r = 2.0 * scene.RoadAt(kFoot);
  scene.Render(kFoot, r);
  for (const float x : {0.0f, 2.0f, kImage.width - 1.0f}) {
    EXPECT_NEAR(scene.FootRow({x, kFoot + kTop}, {x, kFoot + kBottom}, r), kFoot + kBottom, 1e-4);
  }
  scene.RenderBlank();
  EXPECT_NEAR(scene.FootRow({320.0f, kFoot + kTop}, {320.0f, kFoot + kBottom}, r), kFoot + kBottom,
              1e-4);
}

}  // namespace
}  // namespace egosieve::vision
