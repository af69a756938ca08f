#include "vision/synthetic/scene_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vision/synthetic/noise.h"
#include "vision/synthetic/street_grid.h"

namespace egosieve::vision {
namespace {

constexpr double kLongMetres = 1e6;  // paths continue straight beyond their ends

// Half the length, and the radius, of the chain of discs that represents a model in clearance
// tests.
struct Clearance {
  double half_length;
  double radius;
};

Clearance ClearanceOf(ObjectClass object_class) {
  const ObjectFacts& facts = FactsOf(object_class);
  return {std::max(0.0, facts.half_length - facts.half_width), facts.half_width};
}

// Distance between two chains of discs, from centre lines sampled at both ends and the middle.
double Gap(const DriveState& a, const Clearance& ca, const DriveState& b, const Clearance& cb) {
  double gap = 1e9;
  for (const double i : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    const Eigen::Vector2d p = a.pose.position + i * ca.half_length * a.pose.Forward();
    for (const double j : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
      const Eigen::Vector2d q = b.pose.position + j * cb.half_length * b.pose.Forward();
      gap = std::min(gap, (p - q).norm());
    }
  }
  return gap - ca.radius - cb.radius;
}

}  // namespace

SceneBuilder::SceneBuilder(uint64_t seed, double duration_seconds)
    : seed_(Hash(static_cast<uint32_t>(seed) ^ Hash(static_cast<uint32_t>(seed >> 32) + 1u))),
      duration_(duration_seconds) {
  scene.seed = seed_;
  scene.ground.seed = Hash(seed_ + 1);
  scene.camera.seed = Hash(seed_ + 2);
  scene.own_vehicle.seed = Hash(seed_ + 4);
  town.seed = Hash(seed_ + 3);
  const double azimuth = Uniform(0.0, 2.0 * M_PI), elevation = Uniform(0.7, 1.05);
  scene.light.to_sun = {std::cos(azimuth) * std::cos(elevation),
                        std::sin(azimuth) * std::cos(elevation), std::sin(elevation)};
}

double SceneBuilder::Uniform(double low, double high) {
  return low + (high - low) * Unit(Hash(seed_ + 1000u, static_cast<int32_t>(draws_++)));
}

void SceneBuilder::DriveCamera(double start_x, std::vector<SpeedKey> keys) {
  Path path({start_x, -kLaneCentre}, 0.0);
  path.Straight(kLongMetres);
  scene.camera.drive = Drive(std::move(path), 0.0, std::move(keys));
}

void SceneBuilder::TurnCamera(double start_x, int side, std::vector<SpeedKey> keys) {
  const double radius = side > 0 ? 9.0 : 5.5;
  const double exit = side > 0 ? kLaneCentre : -kLaneCentre;  // x of the lane to turn into
  Path path({start_x, -kLaneCentre}, 0.0);
  path.Straight(exit - radius - start_x).Turn(radius, side * M_PI / 2).Straight(kLongMetres);
  scene.camera.drive = Drive(std::move(path), 0.0, std::move(keys));
}

void SceneBuilder::RoundCamera(double round_seconds) {
  constexpr double kRadius = 9.0, kQuarter = M_PI / 2;
  const double width = kPitchX + 2.0 * kLaneCentre, depth = kPitchY + 2.0 * kLaneCentre;
  const double length = 2.0 * (width + depth) - 8.0 * kRadius + 2.0 * M_PI * kRadius;
  Path path({-kPitchX / 2, -kLaneCentre}, 0.0);
  for (double t = 0.0; t < duration_ + round_seconds; t += round_seconds) {
    path.Straight(width / 2 - kRadius).Turn(kRadius, kQuarter);
    path.Straight(depth - 2.0 * kRadius).Turn(kRadius, kQuarter);
    path.Straight(width - 2.0 * kRadius).Turn(kRadius, kQuarter);
    path.Straight(depth - 2.0 * kRadius).Turn(kRadius, kQuarter);
    path.Straight(width / 2 - kRadius);
  }
  scene.camera.drive = Drive(std::move(path), 0.0, {{0.0, length / round_seconds}});
}

void SceneBuilder::WalkCamera(double start_x, double speed, double sway_radians,
                              double yaw_radians) {
  Path path({start_x, -7.9}, 0.0);
  path.Straight(kLongMetres);
  CameraRig& rig = scene.camera;
  rig.drive = Drive(std::move(path), 0.0, {{0.0, speed}});
  rig.height_metres = 1.62 + kKerbHeight;
  rig.unevenness = 0.0;
  rig.sway_radians = sway_radians;
  rig.bob_metres = speed > 0.0 ? 0.025 : 0.0;
  rig.yaw_radians = yaw_radians;
}

void SceneBuilder::LineTheWay() {
  const double y = scene.camera.drive.At(0.0).pose.position.y();
  const double from = CameraX(0.0), to = CameraX(duration_) + 25.0;
  for (double x = from + 1.5; x < to; x += Uniform(2.5, 5.0)) {
    const double side = Uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
    AppendTree({x, y + side * Uniform(0.9, 1.2), kKerbHeight}, Uniform(9.0, 13.0),
               Hash(seed_ + 3000u, static_cast<int32_t>(draws_++)), &scene.scenery);
  }
  for (double x = from - 2.0; x < to; x += 9.0) {
    AppendRailing({x, y + 1.5, kKerbHeight}, {x + 7.5, y + 1.5, kKerbHeight}, &scene.scenery);
  }
}

double SceneBuilder::CameraX(double seconds) const {
  return scene.camera.drive.At(seconds).pose.position.x();
}

double SceneBuilder::CameraArrival(double x) const {
  for (double t = 0.0; t < duration_; t += 0.1) {
    if (CameraX(t) >= x) return t;
  }
  return duration_;
}

bool SceneBuilder::Clear(const SceneObject& candidate) const {
  const Clearance own = ClearanceOf(candidate.object_class);
  const Clearance car = ClearanceOf(ObjectClass::kCar);
  const double margin = own.radius > 0.5 ? 0.25 : 0.1;
  for (double t = 0.0; t <= duration_ + 0.2; t += 0.2) {
    const DriveState state = candidate.drive.At(t);
    if (Gap(state, own, scene.camera.drive.At(t), car) < margin + 0.1) return false;
    for (const SceneObject& other : scene.objects) {
      const DriveState there = other.drive.At(t);
      if ((there.pose.position - state.pose.position).squaredNorm() > 200.0) continue;
      if (Gap(state, own, there, ClearanceOf(other.object_class)) < margin) return false;
    }
  }
  return true;
}

void SceneBuilder::Add(ObjectClass object_class, Path path, double start,
                       std::vector<SpeedKey> keys, double ground) {
  SceneObject object;
  object.object_class = object_class;
  object.seed = Hash(seed_ + 2000u, static_cast<int32_t>(draws_++));
  object.lights_on = scene.light.night;
  object.drive = Drive(std::move(path), start, std::move(keys));
  object.ground_metres = ground;
  if (Clear(object)) scene.objects.push_back(std::move(object));
}

void SceneBuilder::Ahead(ObjectClass object_class, double x, std::vector<SpeedKey> keys) {
  Add(object_class, Path({x, -kLaneCentre}, 0.0), 0.0, std::move(keys), 0.0);
}

void SceneBuilder::Oncoming(ObjectClass object_class, double x, std::vector<SpeedKey> keys) {
  Add(object_class, Path({x, kLaneCentre}, M_PI), 0.0, std::move(keys), 0.0);
}

void SceneBuilder::Overtaker(ObjectClass object_class, double x, double speed,
                             double return_metres) {
  Path path({x, kLaneCentre}, 0.0);
  path.Straight(kLongMetres);
  if (return_metres > 0.0) path.Shift(return_metres, return_metres + 22.0, -2.0 * kLaneCentre);
  Add(object_class, std::move(path), 0.0, {{0.0, speed}}, 0.0);
}

void SceneBuilder::Crossing(ObjectClass object_class, int i, int side, double seconds,
                            double speed) {
  Path path({i * kPitchX + side * kLaneCentre, 0.0}, side * M_PI / 2);
  Add(object_class, std::move(path), -speed * seconds, {{0.0, speed}}, 0.0);
}

void SceneBuilder::Cyclist(double x, double speed, bool oncoming) {
  const double across = 2.95;
  Add(ObjectClass::kCyclist, Path({x, oncoming ? across : -across}, oncoming ? M_PI : 0.0), 0.0,
      {{0.0, speed}}, 0.0);
}

void SceneBuilder::Walker(double x, int side, int direction, double speed, double across) {
  Add(ObjectClass::kPedestrian, Path({x, side * across}, direction > 0 ? 0.0 : M_PI), 0.0,
      {{0.0, speed}}, kKerbHeight);
}

void SceneBuilder::CrossingWalker(double x, int side, double seconds, double speed) {
  // Waits at the kerb, crosses, and stops on the other side.
  const double width = 2.0 * kKerb + 1.2, crossing = width / speed;
  Path path({x, -side * (kKerb + 0.6)}, side * M_PI / 2);
  Add(ObjectClass::kPedestrian, std::move(path), std::max(0.0, -seconds) * speed,
      {{seconds - 0.3, 0.0},
       {seconds, speed},
       {seconds + crossing, speed},
       {seconds + crossing + 0.3, 0.0}},
      0.0);
}

void SceneBuilder::CrossingWalkers(double spacing_metres) {
  for (double x = CameraX(0.0) + 9.0; x < CameraX(duration_);
       x += spacing_metres * Uniform(0.7, 1.3)) {
    // A walker from the right has left the camera's lane when the camera arrives; one from the left
    // has not reached it yet.
    const bool from_right = Uniform(0.0, 1.0) < 0.6;
    const double ahead = from_right ? Uniform(4.6, 5.6) : Uniform(2.0, 3.0);
    CrossingWalker(x, from_right ? 1 : -1, CameraArrival(x) - ahead, Uniform(1.3, 1.7));
  }
}

void SceneBuilder::Walkers(double per_100_metres) {
  const double from = CameraX(0.0) - 10.0, to = CameraX(duration_) + 70.0;
  const int count = static_cast<int>((to - from) * per_100_metres / 100.0);
  for (int k = 0; k < count; ++k) {
    const double x = Uniform(from, to), speed = Uniform(0.0, 1.0) < 0.15 ? 0.0 : Uniform(0.9, 1.7);
    const int side = Uniform(0.0, 1.0) < 0.5 ? 1 : -1, direction = Uniform(0.0, 1.0) < 0.5 ? 1 : -1;
    Walker(x, side, direction, speed, Uniform(7.0, 8.7));
  }
}

void SceneBuilder::OncomingStream(double gap_metres, double speed) {
  const double end = CameraX(duration_) + speed * duration_ + 60.0;
  for (double x = CameraX(0.0) + 18.0; x < end; x += gap_metres * Uniform(0.6, 1.6)) {
    Oncoming(Uniform(0.0, 1.0) < 0.2 ? ObjectClass::kVan : ObjectClass::kCar, x, {{0.0, speed}});
  }
}

void SceneBuilder::TrafficRound(double every_seconds, double walkers_per_100_metres) {
  constexpr double kSpeed = 8.0, kWalk = 1.3;
  const auto kind = [this] {
    return Uniform(0.0, 1.0) < 0.2 ? ObjectClass::kVan : ObjectClass::kCar;
  };
  for (const int street : {-1, 0}) {
    for (const int side : {-1, 1}) {
      for (double t = -8.0; t < duration_ + 8.0; t += every_seconds * Uniform(0.6, 1.4)) {
        Crossing(kind(), street, side, t, kSpeed * Uniform(0.85, 1.15));
      }
    }
  }
  for (const double y : {kLaneCentre, kPitchY - kLaneCentre}) {  // against the camera's way
    const double heading = y < kPitchY / 2 ? M_PI : 0.0, forwards = heading > 0.0 ? -1.0 : 1.0;
    for (double t = -8.0; t < duration_ + 8.0; t += every_seconds * Uniform(0.6, 1.4)) {
      Add(kind(), Path({-kPitchX / 2 - forwards * kSpeed * t, y}, heading), 0.0, {{0.0, kSpeed}},
          0.0);
    }
  }
  const double reach = kPitchX + kWalk * duration_;
  const auto count = static_cast<int>(2.0 * reach * walkers_per_100_metres / 100.0);
  for (int k = 0; k < count; ++k) {
    const int side = Uniform(0.0, 1.0) < 0.5 ? 1 : -1, direction = Uniform(0.0, 1.0) < 0.5 ? 1 : -1;
    Walker(Uniform(-reach, reach) - kPitchX / 2, side, direction, kWalk, Uniform(7.0, 8.7));
  }
}

void SceneBuilder::CrossingStream(double every_seconds, double speed) {
  const int first = static_cast<int>(std::ceil(CameraX(0.0) / kPitchX));
  const int last = static_cast<int>(std::ceil((CameraX(duration_) + 60.0) / kPitchX));
  for (int i = first; i <= last; ++i) {
    const double arrival = CameraArrival(i * kPitchX - 12.0);
    for (double t = arrival - 9.0; t < std::min(arrival + 6.0, duration_);
         t += every_seconds * Uniform(0.6, 1.5)) {
      const double kind = Uniform(0.0, 1.0);
      const ObjectClass c = kind < 0.12  ? ObjectClass::kBus
                            : kind < 0.3 ? ObjectClass::kVan
                                         : ObjectClass::kCar;
      Crossing(c, i, Uniform(0.0, 1.0) < 0.5 ? 1 : -1, t, speed * Uniform(0.85, 1.15));
    }
  }
}

Scene SceneBuilder::Finish() {
  std::vector<Eigen::Vector2d> points;
  for (double t = 0.0; t <= duration_ + 1.0; t += 1.0)
    points.push_back(scene.camera.drive.At(t).pose.position);
  town.lights_on = scene.light.night;
  AppendTown(town, points, &scene);
  return std::move(scene);
}

}  // namespace egosieve::vision
