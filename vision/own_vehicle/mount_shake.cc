#include "vision/own_vehicle/mount_shake.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "kernels/base/parallel_for.h"
#include "vision/own_vehicle/fixed_pattern.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr double kLowest = 0.25;  // share of the picture's height
constexpr int kRounds = 2, kIterations = 30;
constexpr double kConverged = 1e-5;  // change of the correlation
constexpr int kGradientWindow = 5;   // pixels

cv::Rect LowestPart(cv::Size size) {
  const int height = static_cast<int>(std::lround(kLowest * size.height));
  return {0, size.height - height, size.width, height};
}

cv::Matx23f Identity() { return {1, 0, 0, 0, 1, 0}; }

// The shake of the picture, starting from `shake`.
cv::Matx23f Registered(const cv::Mat1f& median, const cv::Mat1f& picture, cv::Matx23f shake) {
  const cv::Rect part = LowestPart(median.size());
  const auto top = static_cast<float>(part.y);
  // From and to places of the lowest part.
  shake(0, 2) += shake(0, 1) * top;
  shake(1, 2) += shake(1, 1) * top - top;
  cv::Mat found(shake, /*copyData=*/true);
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kIterations,
                               kConverged);
  try {
    cv::findTransformECC(median(part), picture(part), found, cv::MOTION_EUCLIDEAN, until,
                         cv::noArray(), kGradientWindow);
  } catch (const cv::Exception& error) {
    if (error.code != cv::Error::StsNoConv) throw;
    return Identity();
  }
  shake = cv::Matx23f(found.ptr<float>());
  shake(0, 2) -= shake(0, 1) * top;
  shake(1, 2) -= shake(1, 1) * top - top;
  return shake;
}

}  // namespace

cv::Mat1f Steady(const cv::Mat1f& median, const cv::Mat1f& picture, cv::Matx23f& shake) {
  shake = Registered(median, picture, shake);
  cv::Mat1f steady;
  cv::warpAffine(picture, steady, shake, median.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  return steady;
}

cv::Vec2d Steadied(const cv::Matx23f& shake, const cv::Vec2d& place) {
  // Its left half is a rotation.
  const double x = place(0) - shake(0, 2), y = place(1) - shake(1, 2);
  return {shake(0, 0) * x + shake(1, 0) * y, shake(0, 1) * x + shake(1, 1) * y};
}

cv::Mat1b Shaken(const cv::Mat1b& mask, const std::vector<cv::Matx23f>& shakes) {
  cv::Mat1b shaken = cv::Mat1b::zeros(mask.size()), moved;
  for (const cv::Matx23f& shake : shakes) {
    cv::warpAffine(mask, moved, shake, mask.size(), cv::INTER_NEAREST);
    shaken |= moved;
  }
  return shaken;
}

SteadyPictures SteadyOnMount(const std::vector<cv::Mat1f>& pictures) {
  SteadyPictures steady{pictures, {}};
  steady.shakes.assign(pictures.size(), Identity());
  for (int round = 0; round < kRounds; ++round) {
    const cv::Mat1f median = MedianPicture(steady.pictures);
    kernels::ParallelFor(static_cast<int64_t>(pictures.size()), [&](int64_t k) {
      steady.pictures[k] = Steady(median, pictures[k], steady.shakes[k]);
    });
  }
  return steady;
}

double ShareOfLowest(const cv::Mat1b& mask) {
  if (mask.empty()) return 0.0;
  const cv::Rect part = LowestPart(mask.size());
  return static_cast<double>(cv::countNonZero(mask(part))) / part.area();
}

double TypicalShake(const SteadyPictures& steady) {
  const cv::Rect part = LowestPart(steady.pictures[0].size());
  const cv::Vec3f middle(part.x + 0.5f * part.width, part.y + 0.5f * part.height, 1.0f);
  std::vector<double> x, y, distances;
  for (const cv::Matx23f& shake : steady.shakes) {
    const cv::Vec2f place = shake * middle;
    x.push_back(place(0));
    y.push_back(place(1));
  }
  std::vector<double> xs = x, ys = y;
  const double usual_x = MedianInPlace(xs), usual_y = MedianInPlace(ys);
  for (size_t k = 0; k < x.size(); ++k) {
    distances.push_back(std::hypot(x[k] - usual_x, y[k] - usual_y));
  }
  return MedianInPlace(distances);
}

}  // namespace egosieve::vision
