// Where a ray of the camera meets its picture, by the camera models of OpenCV and COLMAP.
//
//   r^2 = u^2 + v^2 of the ray (u, v, 1)
//   perspective  s  = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)         (LE1)
//                u' = s u + 2 p1 u v + p2 (r^2 + 2 u^2)
//                v' = s v + 2 p2 u v + p1 (r^2 + 2 v^2)                                       (LE2)
//   fisheye      t  = atan(r);   (u', v') = (u, v) / r  t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8)
//                                                                                             (LE3)
//   pixels       x  = fx u' + cx,   y = fy v' + cy                                            (LE4)
//
// The centre of the upper left pixel is (0.5, 0.5), as in COLMAP; OpenCV's cx and cy are less by a
// half. Coefficients that a model lacks are 0.
#pragma once

#include <array>

namespace egosieve::vision {

struct Lens {
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  // pixels
  bool is_fisheye = false;
  // k1, k2, p1, p2, k3, k4, k5, k6; of a fisheye k1, k2, k3, k4
  std::array<double, 8> distortion = {};

  // (x, y) of the ray (u, v, 1); not finite where the model has no pixel.
  std::array<double, 2> Project(double u, double v) const;
  // Whether u' = u and v' = v.
  bool is_pinhole() const;
};

}  // namespace egosieve::vision
