#include "vision/synthetic/ray_caster.h"

#include <algorithm>
#include <cmath>

#include "vision/synthetic/noise.h"

namespace egosieve::vision {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kMovableMetres = 220.0;  // farther ones cover a pixel or two
constexpr double kHazeMetres = 1800.0;

std::vector<Primitive> PrimitivesAt(const Scene& scene, double seconds,
                                    const Eigen::Vector2d& near) {
  std::vector<Primitive> primitives = scene.scenery;
  for (size_t k = 0; k < scene.objects.size(); ++k) {
    const DriveState state = scene.objects[k].drive.At(seconds);
    if ((state.pose.position - near).norm() > kMovableMetres) continue;
    AppendModel(scene.objects[k], state, static_cast<int>(k), &primitives);
  }
  return primitives;
}

// `bounds` are those of the first primitives.
std::vector<AlignedBox3d> Continued(std::vector<AlignedBox3d> bounds,
                                    const std::vector<Primitive>& primitives) {
  for (size_t k = bounds.size(); k < primitives.size(); ++k) {
    bounds.push_back(primitives[k].Bounds());
  }
  return bounds;
}

Eigen::AlignedBox2d BoxAround(const Eigen::Vector2d& centre, double reach) {
  return {centre - Eigen::Vector2d::Constant(reach), centre + Eigen::Vector2d::Constant(reach)};
}

Eigen::AlignedBox2d Plan(const std::vector<AlignedBox3d>& bounds) {
  Eigen::AlignedBox2d plan = BoxAround(Eigen::Vector2d::Zero(), 1.0);
  for (const AlignedBox3d& box : bounds) {
    plan.extend(box.min().head<2>());
    plan.extend(box.max().head<2>());
  }
  return plan;
}

PinholeView FitPinhole(const Intrinsics& intrinsics, int width, int height) {
  PinholeView view{intrinsics, width, height};
  if (intrinsics.radial == 0.0) return view;
  // Corners reach farthest with a barrel distortion, the middles of the sides with a pincushion
  // distortion.
  Eigen::AlignedBox2d reach;
  for (const double x : {-1.0, 0.5 * (width - 1), 1.0 * width}) {
    for (const double y : {-1.0, 0.5 * (height - 1), 1.0 * height}) {
      reach.extend(intrinsics.focal_pixels * intrinsics.Undistort(x, y));
    }
  }
  view.intrinsics.radial = 0.0;
  view.intrinsics.centre_x = -reach.min().x();
  view.intrinsics.centre_y = -reach.min().y();
  view.width = static_cast<int>(std::ceil(reach.sizes().x())) + 1;
  view.height = static_cast<int>(std::ceil(reach.sizes().y())) + 1;
  return view;
}

}  // namespace

SceneIndex::SceneIndex(const Scene& scene)
    : bounds(Continued({}, scene.scenery)),
      shadows(ListShadows(bounds, 0, scene.light.to_sun, Plan(bounds))) {}

RayCaster::RayCaster(const Scene& scene, const SceneIndex& index, double seconds, int width,
                     int height)
    : scene_(scene),
      index_(index),
      seconds_(seconds),
      pinhole_(FitPinhole(scene.intrinsics, width, height)),
      pose_(scene.camera.At(seconds)),
      primitives_(PrimitivesAt(scene, seconds, pose_.centre.head<2>())),
      bounds_(Continued(index.bounds, primitives_)),
      movable_shadows_(ListShadows(bounds_, index.bounds.size(), scene.light.to_sun,
                                   BoxAround(pose_.centre.head<2>(), 90.0))),
      view_(ListView(bounds_, pinhole_, pose_)) {
  for (const Vector3d& lamp : scene.lamps) {
    if (scene.light.night && (lamp - pose_.centre).norm() < 90.0) near_lamps_.push_back(lamp);
  }
}

Vector3d RayCaster::RayDirection(double x, double y) const {
  return pose_.rotation * scene_.intrinsics.Undistort(x, y).homogeneous();
}

Vector3d RayCaster::PointAt(double x, double y, double depth) const {
  const Vector3d direction = RayDirection(x, y);
  return std::isinf(depth) ? direction : (pose_.centre + depth * direction).eval();
}

Color RayCaster::Sky(const Vector3d& direction) const {
  const Vector3d d = direction.normalized();
  const float up = static_cast<float>(std::max(d.z(), 0.0));
  if (scene_.light.night) {
    return Color(0.010f, 0.013f, 0.024f) * (1.0f + 2.0f * std::exp(-6.0f * up));
  }
  const Color zenith(0.25f, 0.42f, 0.75f), horizon(0.78f, 0.82f, 0.86f);
  Color sky = horizon + (zenith - horizon) * std::pow(up, 0.5f);
  const float scale = 1.0f / (up + 0.12f);
  const float u = static_cast<float>(d.x()) * scale, v = static_cast<float>(d.y()) * scale;
  const float cloud =
      0.42f * FractalNoise(u, v, scene_.seed + 31, 0.004f * scale * scale, {1.3f, 8, 0.7f});
  const float cover =
      Clamp01(2.2f * (cloud + 0.25f * static_cast<float>(scene_.light.cloud_cover)));
  const float thick = 1.25f - 0.75f * Clamp01(cloud + 0.2f);
  return sky + cover * (Color(1.0f, 0.99f, 0.97f) * thick - sky);
}

float RayCaster::Clouds(const Vector3d& point, double seconds) const {
  const Eigen::Vector2d q =
      (ShadowPlace(point, scene_.light.to_sun) - scene_.light.wind * seconds) / 45.0;
  const float density = FractalNoise(static_cast<float>(q.x()), static_cast<float>(q.y()),
                                     scene_.seed + 37, 0.01f, {1.0f, 3, 0.5f});
  return 1.0f - static_cast<float>(scene_.light.cloud_cover) * Clamp01(0.5f + 1.6f * density);
}

bool RayCaster::Shaded(const Vector3d& point, const Vector3d& normal) const {
  const Ray ray{point + 2e-3 * normal, scene_.light.to_sun};
  Hit hit;
  const Eigen::Vector2d place = ShadowPlace(point, scene_.light.to_sun);
  for (const CandidateLists* shadows : {&index_.shadows, &movable_shadows_}) {
    for (const Candidate& candidate : shadows->At(place)) {
      if (Intersect(primitives_[candidate.primitive], ray, 1e-3, &hit)) return true;
    }
  }
  return false;
}

// Street lamps, and the camera car's own headlights.
Color RayCaster::LampLight(const Vector3d& point, const Vector3d& normal) const {
  float sum = 0.0f;
  for (const Vector3d& lamp : near_lamps_) {
    const Vector3d to_lamp = lamp - point;
    const double distance = to_lamp.norm();
    if (distance > 30.0) continue;
    const double facing = std::max(0.0, normal.dot(to_lamp) / distance);
    sum += static_cast<float>(18.0 * (0.15 + facing) / (4.0 + distance * distance));
  }
  const Vector3d local = pose_.rotation.transpose() * (point - pose_.centre);
  const double beam =
      std::exp(-std::pow(local.x() / (0.35 * local.z() + 0.5), 2.0) -
               std::pow((local.y() - 0.06 * local.z()) / (0.16 * local.z() + 0.4), 2.0));
  const float head = static_cast<float>(70.0 * beam / (30.0 + local.squaredNorm()));
  return sum * Color(1.0f, 0.78f, 0.5f) + head * Color(1.0f, 0.96f, 0.88f);
}

Color RayCaster::Light(const Vector3d& point, const Vector3d& normal, bool* lit) const {
  const LightSettings& light = scene_.light;
  const float up = static_cast<float>(0.5 + 0.5 * normal.z());
  Color sum = light.sky * up + light.bounce * (1.0f - up);
  if (light.night) return sum + LampLight(point, normal);
  const double facing = normal.dot(light.to_sun);
  if (facing > 0.0) {
    const float clouds = Clouds(point, seconds_);
    *lit = !Shaded(point, normal);
    if (*lit) sum += light.sun * (static_cast<float>(facing) * clouds);
  }
  return sum;
}

Hit RayCaster::Trace(const Ray& ray, const Eigen::Vector2d& u) const {
  const Eigen::Vector2d pixel = pinhole_.intrinsics.Project(u.homogeneous());
  const auto nearest = [](double at, int count) {
    return static_cast<double>(std::clamp<int64_t>(std::lround(at), 0, count - 1));
  };
  Hit hit;
  if (ray.direction.z() < 0.0) hit.t = -ray.origin.z() / ray.direction.z();
  for (const Candidate& candidate :
       view_.At({nearest(pixel.x(), pinhole_.width), nearest(pixel.y(), pinhole_.height)})) {
    if (candidate.depth >= hit.t) break;
    if (Intersect(primitives_[candidate.primitive], ray, 1e-3, &hit))
      hit.primitive = candidate.primitive;
  }
  return hit;
}

Vector3d RayCaster::NormalAt(const Hit& hit, const Ray& ray) const {
  if (hit.primitive < 0) return Vector3d::UnitZ();
  const Vector3d normal = primitives_[hit.primitive].rotation * hit.local_normal;
  return normal.dot(ray.direction) > 0.0 ? -normal : normal;  // the inside of a tree's crown
}

SurfaceColor RayCaster::Texture(const Hit& hit, const Ray& ray, const Vector3d& normal,
                                double pixel_share) const {
  const double slope = std::max(-normal.dot(ray.direction) / ray.direction.norm(), 0.02);
  // Between the pixel's extent across the view, t / f, and along it, t / (f slope), with exponent
  // 5/8.
  const double root = std::sqrt(slope);
  const float footprint = static_cast<float>(
      pixel_share * hit.t / (scene_.intrinsics.focal_pixels * (root * std::sqrt(std::sqrt(root)))));
  if (hit.primitive >= 0)
    return SurfaceAt(primitives_[hit.primitive], hit, footprint, scene_.texture);
  const Vector3d point = ray.origin + hit.t * ray.direction;
  return GroundAlbedo(scene_.ground, point.head<2>(), footprint);
}

Color RayCaster::ThroughHaze(const Color& radiance, double depth) const {
  const float clear = static_cast<float>(std::exp(-depth / kHazeMetres));
  const Color haze = scene_.light.night ? Color(0.02f, 0.022f, 0.03f) : Color(0.72f, 0.77f, 0.82f);
  return radiance * clear + haze * (1.0f - clear);
}

Sample RayCaster::Cast(double x, double y) const {
  const Eigen::Vector2d u = scene_.intrinsics.Undistort(x, y);
  const Ray ray{pose_.centre, pose_.rotation * u.homogeneous()};
  Sample sample;
  sample.hit = Trace(ray, u);
  if (std::isinf(sample.depth())) return sample;
  const Vector3d normal = NormalAt(sample.hit, ray);
  sample.light = Light(ray.origin + sample.hit.t * ray.direction, normal, &sample.lit);
  if (sample.hit.primitive >= 0) sample.object = primitives_[sample.hit.primitive].object;
  return sample;
}

Color RayCaster::Radiance(double x, double y) const {
  const Ray ray{pose_.centre, RayDirection(x, y)};
  const Sample sample = Cast(x, y);
  if (std::isinf(sample.depth())) return Sky(ray.direction);
  const SurfaceColor surface = Texture(sample.hit, ray, NormalAt(sample.hit, ray), 0.7);
  return ThroughHaze(surface.albedo * sample.light + surface.emission, sample.depth());
}

Color RayCaster::RadianceInside(double x, double y, const Sample& sample) const {
  if (std::isinf(sample.depth())) return Sky(RayDirection(x, y));
  SurfaceColor sum;
  int count = 0;
  for (const auto& offset : kSubpixels) {
    const Ray ray{pose_.centre, RayDirection(x + offset[0], y + offset[1])};
    Hit hit;
    hit.primitive = sample.hit.primitive;
    if (hit.primitive < 0) {
      if (!(ray.direction.z() < 0.0)) continue;
      hit.t = -ray.origin.z() / ray.direction.z();
    } else if (!Intersect(primitives_[hit.primitive], ray, 1e-3, &hit)) {
      continue;
    }
    const SurfaceColor surface = Texture(hit, ray, NormalAt(hit, ray), 0.7);
    sum.albedo += surface.albedo;
    sum.emission += surface.emission;
    ++count;
  }
  if (count == 0) return Radiance(x, y);
  return ThroughHaze((sum.albedo * sample.light + sum.emission) / static_cast<float>(count),
                     sample.depth());
}

}  // namespace egosieve::vision
