#include "vision/geometry/lens.h"

#include <algorithm>
#include <cmath>

namespace egosieve::vision {

std::array<double, 2> Lens::Project(double u, double v) const {
  const std::array<double, 8>& d = distortion;
  const double r2 = u * u + v * v;
  if (is_fisheye) {
    const double r = std::sqrt(r2);
    const double t = std::atan(r), t2 = t * t;
    const double along = t * (1.0 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3]))));
    const double scale = r > 0.0 ? along / r : 1.0;
    return {fx * scale * u + cx, fy * scale * v + cy};
  }
  const double s =
      (1.0 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))) / (1.0 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])));
  return {fx * (s * u + 2.0 * d[2] * u * v + d[3] * (r2 + 2.0 * u * u)) + cx,
          fy * (s * v + 2.0 * d[3] * u * v + d[2] * (r2 + 2.0 * v * v)) + cy};
}

bool Lens::is_pinhole() const {
  return !is_fisheye && std::all_of(distortion.begin(), distortion.end(),
                                    [](double coefficient) { return coefficient == 0.0; });
}

}  // namespace egosieve::vision
