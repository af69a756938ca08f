#include "vision/own_vehicle/fixed_pattern.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr int kLongestSide = 640;        // of the reduced picture
constexpr double kLeastOfPattern = 0.6;  // correlation
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
  cv::Sobel(values_, gx_, CV_32F, 1, 0, 3, 1.0 / 8.0);
  cv::Sobel(values_, gy_, CV_32F, 0, 1, 3, 1.0 / 8.0);
  mean_gx_ = Mean(gx_);
  mean_gy_ = Mean(gy_);
  variance_ = Covariance(values_, values_, mean_, mean_);
  xx_ = Covariance(gx_, gx_, mean_gx_, mean_gx_);
  xy_ = Covariance(gx_, gy_, mean_gx_, mean_gy_);
  yy_ = Covariance(gy_, gy_, mean_gy_, mean_gy_);
  xm_ = Covariance(gx_, values_, mean_gx_, mean_);
  ym_ = Covariance(gy_, values_, mean_gy_, mean_);
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
