// Pinhole camera with square pixels and the principal point in the middle of the image.
//
//   x = K X / X_3,   K = [ f 0 c_x; 0 f c_y; 0 0 1 ]
//
// x in pixels, X in any unit of length.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace egosieve::vision {

struct Pinhole {
  double focal_pixels = 1.0;
  double centre_x = 0.0, centre_y = 0.0;

  static Pinhole Of(cv::Size image, double focal_pixels) {
    return {focal_pixels, 0.5 * (image.width - 1), 0.5 * (image.height - 1)};
  }

  Eigen::Matrix3d Matrix() const {
    Eigen::Matrix3d k;
    k << focal_pixels, 0, centre_x, 0, focal_pixels, centre_y, 0, 0, 1;
    return k;
  }
  Eigen::Vector3d Ray(double x, double y) const {
    return {(x - centre_x) / focal_pixels, (y - centre_y) / focal_pixels, 1.0};
  }
  Eigen::Vector2d Project(const Eigen::Vector3d& point) const {
    return {centre_x + focal_pixels * point(0) / point(2),
            centre_y + focal_pixels * point(1) / point(2)};
  }
};

}  // namespace egosieve::vision
