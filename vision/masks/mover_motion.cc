#include "vision/masks/mover_motion.h"

#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr double kStiffness = 7.0;  // pixels
constexpr int kMotionRounds = 5;

cv::Point2d Times(const cv::Matx22d& matrix, cv::Point2d p) {
  return {matrix(0, 0) * p.x + matrix(0, 1) * p.y, matrix(1, 0) * p.x + matrix(1, 1) * p.y};
}

}  // namespace

cv::Point2d MoverMotion::At(cv::Point2d place) const {
  return shift + Times(gradient, place - centre);
}

cv::Point2d MoverMotion::Source(cv::Point2d place) const {
  const cv::Matx22d inverse = (cv::Matx22d::eye() + gradient).inv();
  return centre + Times(inverse, place - shift - centre);
}

MoverMotion FitMotion(const std::vector<cv::Point2f>& places,
                      const std::vector<cv::Point2f>& displacements, double scale) {
  MoverMotion motion;
  motion.gradient = cv::Matx22d::zeros();
  if (places.empty()) return motion;
  std::vector<float> along_x, along_y;
  for (size_t i = 0; i < places.size(); ++i) {
    motion.centre += cv::Point2d(places[i]);
    along_x.push_back(displacements[i].x);
    along_y.push_back(displacements[i].y);
  }
  motion.centre /= static_cast<double>(places.size());
  motion.shift = {Median(along_x), Median(along_y)};
  for (int round = 0; round < kMotionRounds; ++round) {
    cv::Matx33d normal = cv::Matx33d::zeros();
    cv::Matx<double, 3, 2> right = cv::Matx<double, 3, 2>::zeros();
    for (size_t i = 0; i < places.size(); ++i) {
      const cv::Point2d offset = cv::Point2d(places[i]) - motion.centre;
      const cv::Point2d d(displacements[i]);
      const double r = cv::norm(d - motion.At(places[i])) / scale;
      const double weight = 1.0 / ((1.0 + r * r) * (1.0 + r * r));
      const cv::Matx31d row(1.0, offset.x, offset.y);
      normal += weight * (row * row.t());
      normal(1, 1) += weight * kStiffness * kStiffness;
      normal(2, 2) += weight * kStiffness * kStiffness;
      right += weight * (row * cv::Matx12d(d.x, d.y));
    }
    // The weights are positive, and so is the matrix.
    const cv::Matx<double, 3, 2> solution = normal.inv() * right;
    motion.shift = {solution(0, 0), solution(0, 1)};
    motion.gradient = {solution(1, 0), solution(2, 0), solution(1, 1), solution(2, 1)};
  }
  return motion;
}

}  // namespace egosieve::vision
