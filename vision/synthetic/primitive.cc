#include "vision/synthetic/primitive.h"

#include <cmath>
#include <utility>

#include "vision/synthetic/noise.h"

namespace egosieve::vision {
namespace {

using Eigen::Vector3d;

struct Interval {
  double near = -std::numeric_limits<double>::infinity();
  double far = std::numeric_limits<double>::infinity();
  int near_face = -1;
  int far_face = -1;
  bool empty() const { return !(near < far); }
};

// Cuts off what does not fulfil speed t <= room; `end` is room / speed.
inline void Clip(double speed, double room, double end, int face, Interval* interval) {
  if (speed == 0.0) {
    if (!(room >= 0.0)) interval->far = -std::numeric_limits<double>::infinity();
  } else if (speed < 0.0 && end > interval->near) {
    interval->near = end;
    interval->near_face = face;
  } else if (speed > 0.0 && end < interval->far) {
    interval->far = end;
    interval->far_face = face;
  }
}

// a t^2 + 2 b t + c <= 0.
inline bool ClipQuadric(double a, double b, double c, Interval* interval) {
  const double discriminant = b * b - a * c;
  if (!(discriminant > 0.0) || !(a > 0.0)) {
    return !(a > 0.0) && c <= 0.0;  // parallel to a cylinder's axis, inside the cylinder
  }
  const double root = std::sqrt(discriminant);
  interval->near = (-b - root) / a;
  interval->far = (-b + root) / a;
  interval->near_face = interval->far_face = 0;
  return true;
}

Interval ConvexInterval(const Primitive& p, const Vector3d& o, const Vector3d& d) {
  Interval interval;
  const Vector3d& h = p.half_size;
  const Vector3d so = o.cwiseQuotient(h), sd = d.cwiseQuotient(h);
  bool meets = true;
  if (p.shape == Shape::kEllipsoid) {
    meets = ClipQuadric(sd.squaredNorm(), so.dot(sd), so.squaredNorm() - 1.0, &interval);
  } else if (p.shape == Shape::kCylinder) {
    meets = ClipQuadric(sd.x() * sd.x() + sd.y() * sd.y(), so.x() * sd.x() + so.y() * sd.y(),
                        so.x() * so.x() + so.y() * so.y() - 1.0, &interval);
  }
  if (!meets) interval.far = interval.near;
  int face = p.shape == Shape::kCylinder ? 1 : 0;
  if (p.shape == Shape::kProfile) {
    for (const HalfSpace& space : p.profile->half_spaces) {
      const double speed = space.normal.dot(d), room = space.offset - space.normal.dot(o);
      Clip(speed, room, room / speed, face++, &interval);
    }
  } else if (meets && p.shape != Shape::kEllipsoid) {
    for (int axis = p.shape == Shape::kCylinder ? 2 : 0; axis < 3; ++axis) {
      const double inverse = 1.0 / d[axis];
      Clip(-d[axis], h[axis] + o[axis], (-h[axis] - o[axis]) * inverse, face++, &interval);
      Clip(d[axis], h[axis] - o[axis], (h[axis] - o[axis]) * inverse, face++, &interval);
    }
  }
  return interval;
}

Vector3d LocalNormal(const Primitive& p, const Vector3d& local, int face) {
  switch (p.shape) {
    case Shape::kBox: {
      Vector3d normal = Vector3d::Zero();
      normal[face / 2] = face % 2 == 0 ? -1.0 : 1.0;
      return normal;
    }
    case Shape::kEllipsoid:
      return local.cwiseQuotient(p.half_size.cwiseProduct(p.half_size)).normalized();
    case Shape::kCylinder:
      if (face == 0) return Vector3d(local.x(), local.y(), 0.0).normalized();
      return Vector3d(0.0, 0.0, face == 1 ? -1.0 : 1.0);
    case Shape::kProfile:
      return p.profile->half_spaces[face].normal;
  }
  return Vector3d::UnitZ();
}

// Whether a cutout material has a hole at this point of its surface.
bool IsHole(const Primitive& p, const Vector3d& local, int face) {
  if (p.appearance.material == Material::kFoliage) {
    const Eigen::Vector3f q = (local * 3.3).cast<float>();
    const float coarse = ValueNoise(q.x(), q.y(), q.z(), p.appearance.seed);
    if (coarse > 0.75f) return false;
    const float fine = ValueNoise(q.x() * 3.7f, q.y() * 3.7f, q.z() * 3.7f, p.appearance.seed + 77);
    return coarse + 1.2f * fine < -0.15f;
  }
  if (p.appearance.material == Material::kSpokes && face != 0) {
    const double radius = std::hypot(local.x(), local.y()) / p.half_size.x();
    if (radius > 0.87 || radius < 0.12) return false;
    const double angle = std::atan2(local.y(), local.x()) * (8.0 / M_PI);
    return std::abs(angle - std::round(angle)) > 0.06;
  }
  return false;
}

}  // namespace

std::shared_ptr<const Profile> MakeProfile(const std::vector<Eigen::Vector2d>& points,
                                           double half_width, double lean) {
  auto profile = std::make_shared<Profile>();
  Eigen::Vector3d& h = profile->half_size;
  for (size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector2d& from = points[k];
    const Eigen::Vector2d edge = points[(k + 1) % points.size()] - from;
    const Vector3d normal = Vector3d(edge.y(), 0.0, -edge.x()).normalized();
    profile->half_spaces.push_back({normal, normal.x() * from.x() + normal.z() * from.y()});
    h = h.cwiseMax(Vector3d(std::abs(from.x()), half_width - std::min(0.0, lean * from.y()),
                            std::abs(from.y())));
  }
  for (const double side : {-1.0, 1.0}) {
    const double scale = 1.0 / std::hypot(1.0, lean);
    profile->half_spaces.push_back({Vector3d(0.0, side, lean) * scale, half_width * scale});
  }
  return profile;
}

Eigen::AlignedBox3d Primitive::Bounds() const {
  const Vector3d& h = profile ? profile->half_size : half_size;
  const Vector3d reach = rotation.cwiseAbs() * h;
  return Eigen::AlignedBox3d(origin - reach, origin + reach);
}

bool Intersect(const Primitive& primitive, const Ray& ray, double t_min, Hit* hit) {
  const Vector3d o = primitive.rotation.transpose() * (ray.origin - primitive.origin);
  const Vector3d d = primitive.rotation.transpose() * ray.direction;
  const Interval interval = ConvexInterval(primitive, o, d);
  if (interval.empty() || !(interval.far > t_min) || !(interval.near < hit->t)) return false;
  const Material material = primitive.appearance.material;
  const bool cutout = material == Material::kFoliage || material == Material::kSpokes;
  const std::pair<double, int> ends[] = {{interval.near, interval.near_face},
                                         {interval.far, interval.far_face}};
  for (const auto& [t, face] : ends) {
    if (!(t > t_min && t < hit->t) || face < 0) {
      if (cutout) continue;
      return false;
    }
    const Vector3d local = o + t * d;
    if (cutout && IsHole(primitive, local, face)) continue;
    hit->t = t;
    hit->face = face;
    hit->local = local;
    hit->local_normal = LocalNormal(primitive, local, face);
    return true;
  }
  return false;
}

}  // namespace egosieve::vision
