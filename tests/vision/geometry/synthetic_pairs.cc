#include "tests/vision/geometry/synthetic_pairs.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <random>

namespace egosieve::vision::testing {
namespace {

constexpr double kWidth = 1242, kHeight = 375, kFocal = 700;
constexpr double kNearest = 6, kFurthest = 40;  // metres
constexpr double kObjectRadius = 1.5;

class Generator {
 public:
  explicit Generator(uint64_t seed) : engine_(seed) {}
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  // Box and Muller.
  double Normal() {
    const double u = 1.0 - Uniform(0, 1), angle = Uniform(0, 2 * 3.14159265358979323846);
    return std::sqrt(-2 * std::log(u)) * std::cos(angle);
  }

 private:
  std::mt19937_64 engine_;
};

Eigen::Matrix3d Intrinsics() {
  Eigen::Matrix3d k;
  k << kFocal, 0, kWidth / 2, 0, kFocal, kHeight / 2, 0, 0, 1;
  return k;
}

Eigen::Matrix3d Cross(const Eigen::Vector3d& t) {
  Eigen::Matrix3d m;
  m << 0, -t(2), t(1), t(2), 0, -t(0), -t(1), t(0), 0;
  return m;
}

struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // X2 = R X1 + t
};

Pose MakePose(CameraMotion motion, Generator& random) {
  Pose pose;
  if (motion == CameraMotion::kStatic) return pose;
  const double degree = 3.14159265358979323846 / 180;
  const double yaw = random.Uniform(0.3, 1.5) * (random.Uniform(0, 1) < 0.5 ? -1 : 1);
  pose.rotation = (Eigen::AngleAxisd(yaw * degree, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(random.Uniform(-0.4, 0.4) * degree, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  const double length = random.Uniform(0.8, 1.4);
  if (motion == CameraMotion::kForward) {
    pose.translation = -length * Eigen::Vector3d(random.Uniform(-0.1, 0.1), 0.02, 1).normalized();
  } else if (motion == CameraMotion::kSideways || motion == CameraMotion::kPlanar) {
    pose.translation = length * Eigen::Vector3d(random.Uniform(0, 1) < 0.5 ? -1 : 1, 0.05,
                                                random.Uniform(-0.2, 0.2))
                                    .normalized();
  }
  return pose;
}

bool Project(const Eigen::Vector3d& point, double& x, double& y) {
  if (point(2) < 1.0) return false;
  x = kFocal * point(0) / point(2) + kWidth / 2;
  y = kFocal * point(1) / point(2) + kHeight / 2;
  return x >= 0 && y >= 0 && x < kWidth && y < kHeight;
}

Eigen::Vector3d BackProject(double x, double y, double depth) {
  return depth * Eigen::Vector3d((x - kWidth / 2) / kFocal, (y - kHeight / 2) / kFocal, 1);
}

struct Object {
  double x, y, depth;        // of its centre, pixels and metres
  Eigen::Vector3d velocity;  // metres a frame
};

}  // namespace

SyntheticPairs MakeSyntheticPairs(const SyntheticOptions& options) {
  Generator random(options.seed);
  const Pose pose = MakePose(options.motion, random);
  const Eigen::Matrix3d k = Intrinsics(), inverse = k.inverse();
  SyntheticPairs result{.fundamental = inverse.transpose() * Cross(pose.translation) *
                                       pose.rotation * inverse};
  result.homography.setZero();
  // The plane n.X = d of a planar scene: a facade at an angle.
  const Eigen::Vector3d normal = Eigen::Vector3d(random.Uniform(-0.4, 0.4), 0.1, 1).normalized();
  const double distance = random.Uniform(10, 20);
  if (options.motion == CameraMotion::kPlanar) {
    result.homography =
        k * (pose.rotation + pose.translation * normal.transpose() / distance) * inverse;
  } else if (options.motion == CameraMotion::kStatic || options.motion == CameraMotion::kRotation) {
    result.homography = k * pose.rotation * inverse;
  }

  std::vector<Object> objects(4);
  for (Object& object : objects) {
    const double angle = random.Uniform(0, 6.28), speed = random.Uniform(0.4, 1.2);
    object = {random.Uniform(100, kWidth - 100), random.Uniform(80, kHeight - 60),
              random.Uniform(8, 16),
              speed * Eigen::Vector3d(std::cos(angle), 0.3 * std::sin(angle), std::sin(angle))};
  }
  while (static_cast<int>(result.pairs.size()) < options.count) {
    const double kind = random.Uniform(0, 1);
    const bool mover = kind < options.mover_share;
    const bool outlier = !mover && kind < options.mover_share + options.outlier_share;
    PointPair pair;
    Eigen::Vector3d point;
    if (mover) {
      const Object& object = objects[static_cast<size_t>(random.Uniform(0, 4))];
      const double radius = kFocal * kObjectRadius / object.depth;
      point = BackProject(object.x + random.Uniform(-radius, radius),
                          object.y + random.Uniform(-radius, radius),
                          object.depth + random.Uniform(-kObjectRadius, kObjectRadius));
      if (!Project(point, pair.x1, pair.y1)) continue;
      point += object.velocity;
    } else {
      const double x = random.Uniform(0, kWidth), y = random.Uniform(0, kHeight);
      // Even in inverse depth, as pictures of streets are.
      const double depth = 1 / random.Uniform(1 / kFurthest, 1 / kNearest);
      point = BackProject(x, y, depth);
      if (options.motion == CameraMotion::kPlanar) point *= distance / normal.dot(point);
      if (!Project(point, pair.x1, pair.y1)) continue;
    }
    if (!Project(pose.rotation * point + pose.translation, pair.x2, pair.y2)) continue;
    if (outlier) {
      pair.x2 = random.Uniform(0, kWidth);
      pair.y2 = random.Uniform(0, kHeight);
    }
    for (double* coordinate : {&pair.x1, &pair.y1, &pair.x2, &pair.y2}) {
      *coordinate += options.noise_pixels * random.Normal();
    }
    result.pairs.push_back(pair);
    result.is_mover.push_back(mover || outlier);
  }
  return result;
}

}  // namespace egosieve::vision::testing
