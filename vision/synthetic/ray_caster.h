// One instant of a scene, ready to be looked at along any ray.
//
//   (R1) radiance = albedo ( sun max(0, n.l) lit + sky (1 + n_z)/2 + bounce (1 - n_z)/2 + lamps ) +
//   emission (R2) haze: radiance e^(-Z/900) + haze (1 - e^(-Z/900))
//
// `lit` is 0 in the shadow of any primitive and follows the clouds otherwise. All functions are
// const and may be called from several threads.
#ifndef EGOSIEVE_VISION_SYNTHETIC_RAY_CASTER_H_
#define EGOSIEVE_VISION_SYNTHETIC_RAY_CASTER_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "vision/synthetic/scene.h"
#include "vision/synthetic/shadow_grid.h"
#include "vision/synthetic/visibility.h"

namespace egosieve::vision {

// What does not change over a drive, built once: bounds and shadows of the scenery.
class SceneIndex {
 public:
  explicit SceneIndex(const Scene& scene);
  std::vector<Eigen::AlignedBox3d> bounds;
  ShadowGrid shadows;
};

struct Sample {
  Color radiance = Color::Zero();
  double depth = 0.0;    // Z, metres; infinite: the sky
  int object = -1;       // index in Scene::objects
  uint32_t surface = 0;  // differs where primitive or face differ
};

class RayCaster {
 public:
  // `scene` and `index` must outlive the caster.
  RayCaster(const Scene& scene, const SceneIndex& index, double seconds, int width, int height);

  const Pose& pose() const { return pose_; }
  // (x, y) in pixels, inside the image or within half a pixel of it.
  Sample Cast(double x, double y) const;
  // Share of the sun's light that the clouds let through to a point, at any time.
  float Clouds(const Eigen::Vector3d& point, double seconds) const;
  // The world point at depth Z on the ray of a pixel; its direction if Z is infinite.
  Eigen::Vector3d PointAt(double x, double y, double depth) const;

 private:
  Eigen::Vector3d RayDirection(double x, double y) const;
  const Primitive& At(int index) const;
  Color Sky(const Eigen::Vector3d& direction) const;
  Color Light(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;
  Color LampLight(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;
  bool Shaded(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

  const Scene& scene_;
  const SceneIndex& index_;
  double seconds_;
  int width_;
  int height_;
  Pose pose_;
  std::vector<Primitive> movable_;
  std::vector<Eigen::AlignedBox3d> movable_bounds_;
  ShadowGrid movable_shadows_;
  TileVisibility visibility_;
  std::vector<Eigen::Vector3d> near_lamps_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SYNTHETIC_RAY_CASTER_H_
