// Casts rays into one instant of a scene.
//
//   (RC1) radiance = albedo ( sun max(0, n.l) lit + sky (1 + n_z)/2 + bounce (1 - n_z)/2 + lamps )
//                    + emission
//   (RC2) haze: radiance e^(-Z/1800) + haze (1 - e^(-Z/1800))
//
// `lit` is 0 in the shadow of any primitive and follows the clouds otherwise. All functions are
// const and may be called from several threads.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <vector>

#include "vision/synthetic/scene.h"
#include "vision/synthetic/surface.h"
#include "vision/synthetic/visibility.h"

namespace egosieve::vision {

// What is constant over a drive, built once: bounds and shadows of the scenery.
struct SceneIndex {
  explicit SceneIndex(const Scene& scene);
  std::vector<Eigen::AlignedBox3d> bounds;
  CandidateLists shadows;
};

// The point that a ray meets, and the light there.
struct Sample {
  Hit hit;
  Color light = Color::Zero();  // (RC1) without albedo and emission
  bool lit = false;             // by the sun
  int object = -1;              // index in Scene::objects

  double depth() const { return hit.t; }  // Z, metres; infinite: the sky
  // Differs if neighbouring pixels need smoothing: another primitive, face or shadow.
  int32_t Surface() const {
    if (std::isinf(hit.t)) return 0;
    return 2 * (16 * (hit.primitive + 1) + hit.face) + (lit ? 2 : 1);
  }
};

// Offsets of the rays of a smoothed pixel, on a rotated grid.
inline constexpr double kSubpixels[4][2] = {
    {-0.375, -0.125}, {0.125, -0.375}, {0.375, 0.125}, {-0.125, 0.375}};

class RayCaster {
 public:
  // `scene` and `index` must outlive the caster.
  RayCaster(const Scene& scene, const SceneIndex& index, double seconds, int width, int height);

  const Pose& pose() const { return pose_; }
  // (x, y) in pixels, inside the image or within half a pixel of it.
  Sample Cast(double x, double y) const;
  // (RC1) and (RC2) along one ray.
  Color Radiance(double x, double y) const;
  // Mean over a pixel that sees one surface; `sample` is that of its central ray. Texture is
  // evaluated at four points, light at the centre alone.
  Color RadianceInside(double x, double y, const Sample& sample) const;
  // Share of the sun's light that reaches a point through the clouds at any time.
  float Clouds(const Eigen::Vector3d& point, double seconds) const;
  // The world point at depth Z on the ray of a pixel; the ray's direction if Z is infinite.
  Eigen::Vector3d PointAt(double x, double y, double depth) const;

 private:
  Eigen::Vector3d RayDirection(double x, double y) const;
  // u: of the pixel without distortion (Intrinsics::Undistort).
  Hit Trace(const Ray& ray, const Eigen::Vector2d& u) const;
  Eigen::Vector3d NormalAt(const Hit& hit, const Ray& ray) const;
  // `pixel_share`: share of the pixel's width that one ray represents.
  SurfaceColor Texture(const Hit& hit, const Ray& ray, const Eigen::Vector3d& normal,
                       double pixel_share) const;
  Color ThroughHaze(const Color& radiance, double depth) const;
  Color Sky(const Eigen::Vector3d& direction) const;
  Color Light(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, bool* lit) const;
  Color LampLight(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;
  bool Shaded(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

  const Scene& scene_;
  const SceneIndex& index_;
  double seconds_;
  PinholeView pinhole_;
  Pose pose_;
  std::vector<Primitive> primitives_;  // scenery, then what can move
  std::vector<Eigen::AlignedBox3d> bounds_;
  CandidateLists movable_shadows_;
  CandidateLists view_;
  std::vector<Eigen::Vector3d> near_lamps_;
};

}  // namespace egosieve::vision
