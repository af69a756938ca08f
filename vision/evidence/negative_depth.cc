#include "vision/evidence/negative_depth.h"

#include <Eigen/Geometry>
#include <cmath>

#include "vision/evidence/epipolar_line.h"

namespace egosieve::vision {

SignedFlow MeasureSignedFlow(const Pinhole& camera, const RelativePose& pose,
                             const PointPair& pair) {
  SignedFlow flow;
  if (!pose.found()) return flow;
  const EpipolarLine line = LineOf(camera, pose.rotation, pose.translation, pair.x1, pair.y1);
  if (!line.valid) return flow;
  // d^T (dproject/dA) = f (d_x, d_y, -d.(A_xy) / A_3) / A_3.
  const double depth = line.ray(2);
  Eigen::Vector3d g;
  g << line.direction, -line.direction.dot(line.ray.head<2>()) / depth;
  g *= camera.focal_pixels / depth;
  const Eigen::Vector3d j = -line.ray.cross(g);
  const double lens = pose.focal_deviation * FlowByFocal(camera, pose, line);
  const double noise = pose.noise_pixels;
  flow.direction = line.direction;
  flow.along_pixels = line.Along({pair.x2, pair.y2});
  flow.deviation_pixels =
      std::sqrt(2.0 * noise * noise + j.dot(pose.rotation_covariance * j) + lens * lens);
  flow.present = std::isfinite(flow.along_pixels) && flow.deviation_pixels > 0.0;
  return flow;
}

}  // namespace egosieve::vision
