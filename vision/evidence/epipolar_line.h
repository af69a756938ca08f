// The epipolar line of a point of the first frame in the second, parametrised by depth.
//
//   A = R K^-1 x_1,  x_inf = project(A)                                the point at infinity
//   x_2(r) = project(A + r t)                                          r = |t| / Z_1, inverse depth
//   d = dx_2/dr / |dx_2/dr| at r = 0                                   the line's direction
//   s = d.(x_2 - x_inf)                                                signed flow along it, pixels
//   r = s A_3 / (G - s t_3),   G = f |t_xy - t_3 A_xy / A_3|           its inverse
//   dr/ds = A_3 G / (G - s t_3)^2
//
// A static point has r > 0, so s > 0. s < 0 belongs to a depth behind the camera: driving forward,
// it is flow towards the point of expansion.
#pragma once

#include <Eigen/Core>

#include "vision/geometry/pinhole.h"

namespace egosieve::vision {

struct EpipolarLine {
  Eigen::Vector3d ray;        // A
  Eigen::Vector2d infinity;   // x_inf
  Eigen::Vector2d direction;  // d
  double gain = 0.0;          // G
  double forward = 0.0;       // t_3

  // False where the point is at the point of expansion or behind the second camera.
  bool valid = false;

  double Along(const Eigen::Vector2d& x2) const { return direction.dot(x2 - infinity); }
  double InverseDepth(double s) const { return s * ray(2) / (gain - s * forward); }
  double InverseDepthSlope(double s) const {
    const double remaining = gain - s * forward;
    return ray(2) * gain / (remaining * remaining);
  }
  // Whether some depth in (-infinity, infinity) gives this s, short of the point of expansion.
  bool Reachable(double s) const { return gain - s * forward > 0.02 * gain; }
};

// t need not have unit length.
inline EpipolarLine LineOf(const Pinhole& camera, const Eigen::Matrix3d& rotation,
                           const Eigen::Vector3d& t, double x1, double y1) {
  EpipolarLine line;
  line.ray = rotation * camera.Ray(x1, y1);
  line.forward = t(2);
  if (!(line.ray(2) > 0.1)) return line;
  line.infinity = camera.Project(line.ray);
  const Eigen::Vector2d slope =
      camera.focal_pixels * (t.head<2>() - line.ray.head<2>() * (t(2) / line.ray(2)));
  line.gain = slope.norm();
  // At the point of expansion the direction of the line is undefined.
  if (!(line.gain > 1e-9)) return line;
  line.direction = slope / line.gain;
  line.valid = true;
  return line;
}

}  // namespace egosieve::vision
