#include "vision/trajectory/ground_search.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <opencv2/imgproc.hpp>

namespace egosieve::vision {
namespace {

constexpr int kWidth = 480, kHeight = 300;
constexpr double kSeconds = 1.0 / 30.0, kFactor = 1.2;
constexpr int kPictures = 6;
const Pinhole kCamera = Pinhole::Of({kWidth, kHeight}, 400.0);

// A blank road with lane marks, 3 heights long every 6, one height to both sides. The camera is one
// height above it and has travelled `way` heights.
uint8_t RoadAt(double across, double ahead, double way) {
  const double along = std::fmod(ahead + way, 6.0);
  const bool is_mark = std::abs(std::abs(across) - 1.0) < 0.08 && along < 3.0;
  return is_mark ? 220 : 90;
}

cv::Mat1b Picture(double way) {
  constexpr int kFiner = 4;
  cv::Mat1b fine(kHeight * kFiner, kWidth * kFiner, uint8_t{150});
  for (int y = 0; y < fine.rows; ++y) {
    for (int x = 0; x < fine.cols; ++x) {
      const Eigen::Vector3d ray = kCamera.Ray((x + 0.5) / kFiner - 0.5, (y + 0.5) / kFiner - 0.5);
      if (ray(1) > 0.01) fine(y, x) = RoadAt(ray(0) / ray(1), 1.0 / ray(1), way);
    }
  }
  cv::Mat1b picture;
  cv::resize(fine, picture, {kWidth, kHeight}, 0, 0, cv::INTER_AREA);
  return picture;
}

// from: heights that the camera has travelled.
GroundSearchView ViewOf(double speed, double from = 0.0) {
  GroundSearchView view;
  for (int k = 0; k < kPictures; ++k) {
    view.pictures.push_back({Picture(from + k * speed * kSeconds), k * kSeconds});
  }
  view.camera = kCamera;
  return view;
}

int Best(const SpeedLikelihood& likelihood) {
  return static_cast<int>(std::max_element(likelihood.begin(), likelihood.end()) -
                          likelihood.begin());
}

// Over half a second and more of a drive.
SpeedLikelihood SumOver(double speed, const std::function<void(GroundSearchView&)>& edit) {
  SpeedLikelihood sum{};
  for (const double from : {0.0, 0.9, 1.7, 2.6, 3.4, 4.3, 5.1}) {
    GroundSearchView view = ViewOf(speed, from);
    edit(view);
    const SpeedLikelihood likelihood = LikelihoodOfSpeeds(view);
    for (int k = 0; k < kSpeeds; ++k) sum[k] += likelihood[k];
  }
  return sum;
}

TEST(GroundSearch, FindsTheSpeedOfABlankRoadByItsMarks) {
  for (const double speed : {4.0, 10.0, 20.0}) {
    const SpeedLikelihood likelihood = SumOver(speed, [](GroundSearchView&) {});
    const int best = Best(likelihood);
    EXPECT_LT(std::abs(std::log(SpeedAt(best) / speed)), std::log(kFactor)) << speed;
  }
}

// Two cars ahead that keep their distance, the larger part of what has contrast.
void AddTraffic(cv::Mat& picture, int shift) {
  for (const int left : {150, 260}) {
    cv::Mat car = picture(cv::Rect(left + shift, 160, 60, 40));
    for (int y = 0; y < car.rows; ++y) {
      for (int x = 0; x < car.cols; ++x) car.at<uint8_t>(y, x) = (x / 6 + y / 6) % 2 ? 30 : 200;
    }
  }
}

TEST(GroundSearch, IsNotMisledByTrafficAtTheCamerasSpeed) {
  const SpeedLikelihood likelihood = SumOver(10.0, [](GroundSearchView& view) {
    for (int k = 0; k < kPictures; ++k) {
      AddTraffic(view.pictures[k].grey, k / 2);  // by a pixel: cars change as well
    }
  });
  const int best = Best(likelihood);
  EXPECT_LT(std::abs(std::log(SpeedAt(best) / 10.0)), std::log(kFactor));
}

// What is fixed in the image, stronger than the marks, all over the road.
TEST(GroundSearch, IsNotMisledByReflections) {
  const SpeedLikelihood likelihood = SumOver(10.0, [](GroundSearchView& view) {
    for (GroundPicture& picture : view.pictures) {
      for (int y = 160; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          uint8_t& level = picture.grey.at<uint8_t>(y, x);
          if ((x / 9 + y / 7) % 2 == 0) level = static_cast<uint8_t>(level / 2 + 100);
        }
      }
    }
  });
  const int best = Best(likelihood);
  EXPECT_LT(std::abs(std::log(SpeedAt(best) / 10.0)), std::log(kFactor));
}

TEST(GroundSearch, FollowsACameraThatTurns) {
  const Eigen::AngleAxisd turn(0.01, Eigen::Vector3d(0.6, 0.8, 0.0));
  const Eigen::Matrix3d k_matrix = kCamera.Matrix();
  const SpeedLikelihood likelihood = SumOver(10.0, [&](GroundSearchView& view) {
    for (GroundPicture& picture : view.pictures) {
      picture.rotation = PartOfRotation(turn.toRotationMatrix(), picture.seconds / kSeconds);
      const Eigen::Matrix3d h = k_matrix * picture.rotation * k_matrix.inverse();
      cv::Matx33d warp;
      for (int i = 0; i < 9; ++i) warp(i / 3, i % 3) = h(i / 3, i % 3);
      cv::Mat turned;
      cv::warpPerspective(picture.grey, turned, warp, picture.grey.size(), cv::INTER_LINEAR,
                          cv::BORDER_REPLICATE);
      picture.grey = turned;
    }
  });
  const int best = Best(likelihood);
  EXPECT_LT(std::abs(std::log(SpeedAt(best) / 10.0)), std::log(kFactor));
}

TEST(GroundSearch, SaysNothingWhereNothingChanges) {
  const SpeedLikelihood likelihood = LikelihoodOfSpeeds(ViewOf(0.0));
  for (const double value : likelihood) EXPECT_EQ(value, likelihood[0]);
}

TEST(GroundSearch, SaysNothingOfACameraThatMovesSideways) {
  GroundSearchView view = ViewOf(10.0);
  view.direction = Eigen::Vector3d::UnitX();
  const SpeedLikelihood likelihood = LikelihoodOfSpeeds(view);
  for (const double value : likelihood) EXPECT_EQ(value, likelihood[0]);
}

TEST(GroundSearch, SaysNothingOfTwoPictures) {
  GroundSearchView view = ViewOf(10.0);
  view.pictures.resize(2);
  const SpeedLikelihood likelihood = LikelihoodOfSpeeds(view);
  for (const double value : likelihood) EXPECT_EQ(value, likelihood[0]);
}

TEST(GroundSearch, DoesNotLookAtWhatIsIgnored) {
  GroundSearchView view = ViewOf(10.0);
  view.ignored = cv::Mat1b(kHeight, kWidth, uint8_t{255});
  const SpeedLikelihood likelihood = LikelihoodOfSpeeds(view);
  for (const double value : likelihood) EXPECT_EQ(value, likelihood[0]);
}

}  // namespace
}  // namespace egosieve::vision
