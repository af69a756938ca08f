#include "vision/evidence/ground_contact.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/vision/evidence/road_view.h"

namespace egosieve::vision {
namespace {

constexpr double kNoise = 2.0;                           // grey levels
constexpr double kDeviation = 0.05, kUnevenness = 0.05;  // of r, of the road's
constexpr int kTop = -25;  // of a search, rows from the true ground contact

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

// A road and, above the row where it touches it, an object of one inverse depth.
class Scene {
 public:
  Scene() {
    pose_.translation = -Eigen::Vector3d::UnitZ();
    pose_.rotation = RotationOf({0.004, -0.01, 0.003});
    road_.m = {0.0, kTravel / kHeight, 0.0};
  }

  double RoadAt(double row) const { return road_.At(camera_.Ray(0.0, row)); }
  void Render(int contact, double inverse_depth) {
    const cv::Mat road = Texture(1), object = Texture(2);
    cv::Mat is_object(kImage, CV_8UC1, cv::Scalar(0)), now = road.clone();
    is_object.rowRange(0, contact).setTo(255);
    object.copyTo(now, is_object);
    cv::Mat before = Before(road, road_.m);
    const Eigen::Vector3d m(0.0, 0.0, inverse_depth);
    Before(object, m).copyTo(before, Before(is_object, m) > 127);
    now_ = WithNoise(now, 3);
    before_ = WithNoise(before, 4);
  }
  void RenderBlank() { before_ = now_ = cv::Mat(kImage, CV_8UC1, cv::Scalar(120)); }
  ContactRatios Ratios(cv::Point2f top, double inverse_depth, double share = 1.0) const {
    const ContactPictures pictures(road_, camera_, pose_, before_, now_, kNoise);
    const double lowest = LowestGround(road_.At(camera_.Ray(top.x, top.y)), inverse_depth);
    const ContactDepths depths = {inverse_depth, kDeviation * inverse_depth, share, kUnevenness,
                                  lowest};
    return RatiosOfContact(pictures.RowsBelow(top, depths), depths);
  }
  // Of columns all over the picture, for what is nearer by a factor than the road where it touches
  // it.
  std::vector<ContactRatios> RatiosOfColumns(int contact, double nearer) {
    const double r = nearer * RoadAt(contact);
    Render(contact, r);
    std::vector<ContactRatios> ratios;
    for (float x = 40.0f; x < 600.0f; x += 20.0f) {
      ratios.push_back(Ratios({x, contact + float{kTop}}, r));
    }
    return ratios;
  }
  double RowOf(const ContactRatios& ratios) const {
    return camera_.Project({0.0, ratios.ground / road_.m(1), 1.0})(1);
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

// (B2) of rows that surely show the contact: z^2 / 2 of the row where the object ends.
TEST(GroundContact, ARatioByHand) {
  std::vector<ContactRow> rows;
  for (int k = 0; k <= 10; ++k) {
    rows.push_back({k <= 5 ? 4.0 : -4.0, 0.01 * k});
  }
  const auto ratios = [&](double r) { return RatiosOfContact(rows, {r, 0.01, 1.0, 0.0}); };
  // The contact is row 5, where the ground has 0.05: one deviation is 0.01.
  EXPECT_NEAR(ratios(0.02).too_far, 4.5, 1e-12);
  EXPECT_NEAR(ratios(0.045).too_far, 0.125, 1e-12);
  EXPECT_EQ(ratios(0.08).too_far, 0.0);
  EXPECT_NEAR(ratios(1.15 * 0.06).too_near, 0.5, 1e-12);
  EXPECT_NEAR(ratios(1.15 * 0.09).too_near, 8.0, 1e-12);
  EXPECT_EQ(ratios(0.055).too_near, 0.0);  // within what may hang above the ground
  EXPECT_EQ(ratios(0.02).ground, 0.05);
  // Around the object the ground lies lower: 0.03 in row 5. Or higher: 0.06.
  EXPECT_NEAR(RatiosOfContact(rows, {0.02, 0.01, 0.6, 0.0}).too_far, 0.5, 1e-12);
  EXPECT_EQ(RatiosOfContact(rows, {1.15 * 0.06, 0.01, 1.2, 0.0}).too_near, 0.0);
  // The ground's unevenness is part of the deviation.
  EXPECT_NEAR(RatiosOfContact(rows, {0.02, 0.01, 1.0, 0.2}).too_far, 0.5 * 9.0 / (1.0 + 1.0),
              1e-12);
}

TEST(GroundContact, RowsThatAreNotSeenSayNothing) {
  EXPECT_EQ(RatiosOfContact({}, {0.05, 0.01, 1.0, 0.05}).too_far, 0.0);
  std::vector<ContactRow> rows;
  for (int k = 0; k <= 10; ++k) rows.push_back({std::nan(""), 0.01 * k});
  const ContactRatios ratios = RatiosOfContact(rows, {0.02, 0.01, 1.0, 0.05});
  EXPECT_EQ(ratios.too_far, 0.0);
  EXPECT_EQ(ratios.too_near, 0.0);
}

TEST(GroundContact, PicturesTellWhatIsTooNearFromWhatIsTooFar) {
  Scene scene;
  for (const int contact : {240, 290}) {
    for (const double nearer : {0.0, 0.5, 1.6, 2.0}) {
      int marked = 0, count = 0;
      for (const ContactRatios& ratios : scene.RatiosOfColumns(contact, nearer)) {
        // The road right below what is too far was hidden by it: 10 rows of 110 at most.
        const double share = scene.RoadAt(scene.RowOf(ratios)) / scene.RoadAt(contact);
        EXPECT_GT(share, 0.95) << nearer;
        EXPECT_LT(share, nearer < 1.0 ? 1.2 : 1.05) << nearer;
        marked += (nearer < 1.0 ? ratios.too_far : ratios.too_near) > 3.0 ? 1 : 0;
        EXPECT_LT(nearer < 1.0 ? ratios.too_near : ratios.too_far, 0.5) << nearer;
        ++count;
      }
      EXPECT_GT(marked, 0.9 * count) << contact << " " << nearer;
    }
  }
}

// A twentieth of r is the deviation: a likelihood ratio of 1.6 is that of less than two of them.
TEST(GroundContact, WhatStandsIsNeither) {
  Scene scene;
  for (const int contact : {240, 290}) {
    for (const double nearer : {1.0, 1.1}) {
      for (const ContactRatios& ratios : scene.RatiosOfColumns(contact, nearer)) {
        EXPECT_LT(ratios.too_far, 1.6) << nearer;
        EXPECT_LT(ratios.too_near, 1.6) << nearer;
      }
    }
  }
}

// What the places around say of the ground may be wrong: the plane explains the rows as well.
TEST(GroundContact, AWrongShareOfTheGroundMarksNothing) {
  Scene scene;
  constexpr float kContact = 240.0f;
  const double r = scene.RoadAt(kContact);
  scene.Render(kContact, r);
  for (float x = 40.0f; x < 600.0f; x += 20.0f) {
    for (const double share : {0.8, 1.1}) {
      EXPECT_LT(scene.Ratios({x, kContact + kTop}, r, share).too_far, 1.6) << share;
    }
  }
}

TEST(GroundContact, NothingIsSaidWherePicturesDoNotTell) {
  Scene scene;
  constexpr float kContact = 240.0f;
  const double r = 2.0 * scene.RoadAt(kContact);
  scene.Render(kContact, r);
  for (const float x : {0.0f, 2.0f, kImage.width - 1.0f}) {
    EXPECT_EQ(scene.Ratios({x, kContact + kTop}, r).too_near, 0.0) << x;
  }
  scene.RenderBlank();
  EXPECT_EQ(scene.Ratios({320.0f, kContact + kTop}, r).too_near, 0.0);
}

}  // namespace
}  // namespace egosieve::vision
