#include "vision/labelling/lines_along_travel.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "vision/evidence/road_plane.h"
#include "vision/trajectory/ground_bound.h"

namespace egosieve::vision {
namespace {

constexpr int kWindow = 9;             // pixels
constexpr double kMostShare = 0.05;    // of the texture, along the direction of travel
constexpr double kLeastTexture = 4.0;  // grey levels^2 per pixel^2
constexpr double kMostOfGround = 1.0 + 2.0 * kRoadUnevenness;

cv::Mat1f InWindow(const cv::Mat1f& values) {
  cv::Mat1f mean;
  cv::boxFilter(values, mean, CV_32F, cv::Size(kWindow, kWindow));
  return mean;
}

}  // namespace

LinesAlongTravel::LinesAlongTravel(const cv::Mat& grey, const Pinhole& camera,
                                   const Eigen::Vector3d& travel)
    : camera_(camera), travel_(travel) {
  cv::Mat1f x, y;
  cv::Sobel(grey, x, CV_32F, 1, 0, 3, 1.0 / 8.0);
  cv::Sobel(grey, y, CV_32F, 0, 1, 3, 1.0 / 8.0);
  s_xx_ = InWindow(x.mul(x));
  s_xy_ = InWindow(x.mul(y));
  s_yy_ = InWindow(y.mul(y));
}

bool LinesAlongTravel::Contain(cv::Point2f place) const {
  const Eigen::Vector2d ray = camera_.Ray(place.x, place.y).head<2>();
  if (!(Below(ray, travel_) > 0.0)) return false;
  const int column = std::clamp(cvRound(place.x), 0, s_xx_.cols - 1);
  const int row = std::clamp(cvRound(place.y), 0, s_xx_.rows - 1);
  const double xx = s_xx_(row, column), xy = s_xy_(row, column), yy = s_yy_(row, column);
  const Eigen::Vector2d e = travel_.head<2>() - travel_(2) * ray;
  const double along = e(0) * e(0) * xx + 2.0 * e(0) * e(1) * xy + e(1) * e(1) * yy;
  return xx + yy >= kLeastTexture && along < kMostShare * e.squaredNorm() * (xx + yy);
}

bool SeemsNoNearerThanGround(const TwoViewMotion& motion, const Pinhole& camera, cv::Point2f now,
                             cv::Point2f there) {
  const Eigen::Vector2d ray = camera.Ray(now.x, now.y).head<2>();
  const Eigen::Vector3d tau = motion.rotation.transpose() * motion.translation;
  const double ground = LeastInverseDepth(motion.ground_heights, ray, motion.travel.value_or(tau));
  if (!(ground > 0.0)) return false;
  const PairLikelihood likelihood =
      LikelihoodOf(motion, camera, {now.x, now.y, there.x, there.y}, false);
  const double parallax = likelihood.along / (tau.head<2>() - tau(2) * ray).norm();
  return InverseDepthOf(std::max(0.0, parallax), tau) < kMostOfGround * ground;
}

}  // namespace egosieve::vision
