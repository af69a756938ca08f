#include "vision/own_vehicle/fixed_pattern.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr int kLongestSide = 640;        // of the reduced picture
constexpr double kLeastOfPattern = 0.6;  // correlation
constexpr double kLeastShown = 0.85;     // rho^2; below for a shift of about a pixel
constexpr double kSmoothing = 1.0;       // deviation of the Gaussian, pixels
constexpr float kDamping = 1.0F;         // lambda, (grey levels per pixel)^2

cv::Mat1f Mean(const cv::Mat1f& values) {
  cv::Mat1f mean;
  cv::boxFilter(values, mean, CV_32F, {kFixedPatternWindow, kFixedPatternWindow});
  return mean;
}

cv::Mat1f Covariance(const cv::Mat1f& a, const cv::Mat1f& b, const cv::Mat1f& mean_a,
                     const cv::Mat1f& mean_b) {
  return Mean(a.mul(b)) - mean_a.mul(mean_b);
}

cv::Mat1f Gradient(const cv::Mat1f& picture, int dx, int dy) {
  cv::Mat1f gradient;
  cv::Sobel(picture, gradient, CV_32F, dx, dy, 3, 1.0 / 8.0);
  return gradient;
}

}  // namespace

cv::Mat1b ReducedPicture(const cv::Mat1b& grey) {
  const double scale =
      std::min(1.0, static_cast<double>(kLongestSide) / std::max(grey.cols, grey.rows));
  if (scale == 1.0) return grey;
  cv::Mat1b reduced;
  cv::resize(grey, reduced, {}, scale, scale, cv::INTER_AREA);
  return reduced;
}

cv::Mat1f SmoothPicture(const cv::Mat1b& reduced) {
  cv::Mat1f smooth;
  reduced.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {}, kSmoothing);
  return smooth;
}

cv::Mat1f VarianceInWindow(const cv::Mat1f& picture) {
  const cv::Mat1f mean = Mean(picture);
  return Covariance(picture, picture, mean, mean);
}

cv::Mat1f MedianPicture(const std::vector<cv::Mat1f>& pictures) {
  cv::Mat1f median(pictures[0].size());
  std::vector<float> values(pictures.size());
  for (int y = 0; y < median.rows; ++y) {
    for (int x = 0; x < median.cols; ++x) {
      for (size_t k = 0; k < pictures.size(); ++k) values[k] = pictures[k](y, x);
      median(y, x) = MedianInPlace(values);
    }
  }
  return median;
}

FixedPattern::FixedPattern(const cv::Mat1f& median) : values_(median), mean_(Mean(median)) {
  gx_ = Gradient(values_, 1, 0);
  gy_ = Gradient(values_, 0, 1);
  power_ = gx_.mul(gx_) + gy_.mul(gy_);
  mean_power_squared_ = Mean(power_.mul(power_));
  mean_gx_ = Mean(gx_);
  mean_gy_ = Mean(gy_);
  variance_ = Covariance(values_, values_, mean_, mean_);
  xx_ = Covariance(gx_, gx_, mean_gx_, mean_gx_);
  xy_ = Covariance(gx_, gy_, mean_gx_, mean_gy_);
  yy_ = Covariance(gy_, gy_, mean_gy_, mean_gy_);
  xm_ = Covariance(gx_, values_, mean_gx_, mean_);
  ym_ = Covariance(gy_, values_, mean_gy_, mean_);
}

cv::Mat1b FixedPattern::Showing(const cv::Mat1f& picture) const {
  const cv::Mat1f x = Gradient(picture, 1, 0), y = Gradient(picture, 0, 1);
  const cv::Mat1f both = Mean(power_.mul(gx_.mul(x) + gy_.mul(y)));
  const cv::Mat1f squares = mean_power_squared_.mul(Mean(power_.mul(x.mul(x) + y.mul(y))));
  return (both > 0.0) & (both.mul(both) >= kLeastShown * squares);
}

std::vector<cv::Vec2d> FixedPattern::Shifts(
    const cv::Mat1f& picture, const std::vector<std::vector<cv::Point>>& patches) const {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const cv::Mat1f rest = picture - Mean(picture);
  std::vector<cv::Vec2d> shifts;
  for (const std::vector<cv::Point>& patch : patches) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();  // of a, a u_x, a u_y
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const cv::Point at : patch) {
      const Eigen::Vector3d row(values_(at) - mean_(at), gx_(at) - mean_gx_(at),
                                gy_(at) - mean_gy_(at));
      const double weight = power_(at);
      normal += weight * row * row.transpose();
      normal.diagonal().tail<2>().array() += weight * kDamping;
      right += weight * rest(at) * row;
    }
    const Eigen::Vector3d fit = normal.ldlt().solve(right);
    shifts.emplace_back(kInfinite, kInfinite);
    if (fit(0) > 0.0) shifts.back() = {fit(1) / fit(0), fit(2) / fit(0)};
  }
  return shifts;
}

cv::Mat1b FixedPattern::Agreeing(const cv::Mat1f& picture) const {
  const cv::Mat1f mean = Mean(picture);
  const cv::Mat1f variance = Covariance(picture, picture, mean, mean);
  const cv::Mat1f im = Covariance(picture, values_, mean, mean_);
  const cv::Mat1f ix = Covariance(picture, gx_, mean, mean_gx_);
  const cv::Mat1f iy = Covariance(picture, gy_, mean, mean_gy_);
  cv::Mat1b agreeing = cv::Mat1b::zeros(picture.size());
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const double vm = variance_(y, x), vi = variance(y, x), c = im(y, x);
      if (!(vm > 0.0 && vi > 0.0) || !(c >= kLeastOfPattern * std::sqrt(vm * vi))) continue;
      const double a = c / vm;
      const double bx = ix(y, x) / a - xm_(y, x), by = iy(y, x) / a - ym_(y, x);
      const double xx = xx_(y, x) + kDamping, yy = yy_(y, x) + kDamping, xy = xy_(y, x);
      const double determinant = xx * yy - xy * xy;
      const double shift = std::hypot(yy * bx - xy * by, xx * by - xy * bx) / determinant;
      if (shift <= kMostShiftPixels) agreeing(y, x) = 255;
    }
  }
  return agreeing;
}

}  // namespace egosieve::vision
