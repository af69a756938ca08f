// The solids of a synthetic scene, and their intersection with rays.
//
// A primitive has its own frame: world = rotation * local + origin. In this frame
//
//   kBox        |x| <= h_x, |y| <= h_y, |z| <= h_z                h = half_size
//   kEllipsoid  (x/h_x)^2 + (y/h_y)^2 + (z/h_z)^2 <= 1
//   kCylinder   (x/h_x)^2 + (y/h_y)^2 <= 1, |z| <= h_z
//   kProfile    a convex polygon of the x-z plane, extruded along y between two planes that may
//               lean inwards: the body of a car, its cabin, a roof
//
// A ray o + t d, d of any length or with unit component along the camera's axis, meets a convex
// solid in one interval. It is the intersection of the intervals of its half-spaces (boxes,
// profiles) or of its quadric and half-spaces (ellipsoids, cylinders). Cutout materials (leaves,
// spoked wheels) have holes in the surface: a ray through a hole meets the second end of the
// interval.
//
// Faces are numbered: boxes 0..5 = -x, +x, -y, +y, -z, +z; cylinders 0 side, 1 bottom, 2 top;
// ellipsoids 0; profiles: the polygon's edges in order, then -y, +y.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace egosieve::vision {

using Color = Eigen::Array3f;  // linear light: red, green, blue

enum class Shape : uint8_t { kBox, kEllipsoid, kCylinder, kProfile };

enum class Material : uint8_t {
  kPavement,
  kFacade,
  kRoof,
  kCarBody,
  kCarCabin,
  kBus,
  kWheel,
  kSpokes,
  kFoliage,
  kBark,
  kCloth,
  kSkin,
  kMetal,
  kSign,
  kLamp,
};

// A half-space n . p <= offset, in a primitive's frame.
struct HalfSpace {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0.0;
};

struct Profile {
  std::vector<HalfSpace> half_spaces;
  Eigen::Vector3d half_size = Eigen::Vector3d::Zero();  // of its bounding box, centred at 0
};

// The convex polygon `points` (x, z), counter-clockwise, extruded to |y| <= half_width at z = 0,
// leaning inwards by `lean` metres per metre of height.
std::shared_ptr<const Profile> MakeProfile(const std::vector<Eigen::Vector2d>& points,
                                           double half_width, double lean);

struct Appearance {
  Material material = Material::kMetal;
  uint32_t seed = 0;
  Color color = Color(0.5f, 0.5f, 0.5f);
  bool lights_on = false;  // lamps, headlights and lit windows
};

struct Primitive {
  Shape shape = Shape::kBox;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_size = Eigen::Vector3d::Ones();
  std::shared_ptr<const Profile> profile;
  Appearance appearance;
  int object = -1;  // index among the scene's objects; -1: scenery

  Eigen::AlignedBox3d Bounds() const;
};

struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

struct Hit {
  double t = std::numeric_limits<double>::infinity();
  int primitive = -1;  // index in the scene; -1 with finite t: the ground; with infinite t: the sky
  int face = 0;
  Eigen::Vector3d local;         // the point in the primitive's frame
  Eigen::Vector3d local_normal;  // outward
};

// Whether the ray meets the primitive at some t in (t_min, hit->t). If so, fills t, face, local and
// local_normal.
bool Intersect(const Primitive& primitive, const Ray& ray, double t_min, Hit* hit);

}  // namespace egosieve::vision
