#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "vision/synthetic/noise.h"
#include "vision/synthetic/street.h"
#include "vision/synthetic/town.h"

namespace egosieve::vision {
namespace {

constexpr ObjectClass kCar = ObjectClass::kCar;
constexpr ObjectClass kVan = ObjectClass::kVan;
constexpr ObjectClass kBus = ObjectClass::kBus;
constexpr double kLongMetres = 1e6;  // paths continue straight beyond their ends

// Distance between two chains of discs that represent models in clearance tests, from centre lines
// sampled at both ends and the middle.
double Gap(const DriveState& a, const ObjectFacts& of_a, const DriveState& b,
           const ObjectFacts& of_b) {
  double gap = 1e9;
  for (const double i : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    const Eigen::Vector2d p =
        a.pose.position + i * (of_a.half_length - of_a.half_width) * a.pose.Forward();
    for (const double j : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
      const Eigen::Vector2d q =
          b.pose.position + j * (of_b.half_length - of_b.half_width) * b.pose.Forward();
      gap = std::min(gap, (p - q).norm());
    }
  }
  return gap - of_a.half_width - of_b.half_width;
}

}  // namespace

// Vocabulary for scenarios: the camera's drive and the traffic around it.
//
// The camera drives east (along x) on street j = 0. Seconds count from the first frame. A mover is
// added only if it keeps clear of the camera and of all movers added before it for the whole drive.
// Otherwise it is left out, so that crowded scenes stay plausible.
class SceneBuilder {
 public:
  using Speeds = std::vector<SpeedKey>;

  SceneBuilder(uint64_t seed, double duration_seconds)
      : duration(duration_seconds),
        seed_(Hash(static_cast<uint32_t>(seed) ^ Hash(static_cast<uint32_t>(seed >> 32) + 1u))) {
    scene.seed = seed_;
    scene.ground.seed = Hash(seed_ + 1);
    scene.camera.seed = Hash(seed_ + 2);
    scene.own_vehicle.seed = Hash(seed_ + 4);
    const double azimuth = Uniform(0.0, 2.0 * M_PI), elevation = Uniform(0.7, 1.05);
    scene.light.to_sun = {std::cos(azimuth) * std::cos(elevation),
                          std::sin(azimuth) * std::cos(elevation), std::sin(elevation)};
  }

  Scene scene;  // light, sensor, textures and houses may be set directly
  const double duration;

  // From the seed: another seed with each call; uniform in [low, high); true with this probability.
  uint32_t Draw(uint32_t purpose) { return Hash(seed_ + purpose, static_cast<int32_t>(draws_++)); }
  double Uniform(double low, double high) { return low + (high - low) * Unit(Draw(1000u)); }
  bool Chance(double probability) { return Uniform(0.0, 1.0) < probability; }

  // --- Camera. Call one of these first.
  void DriveCamera(double start_x, Speeds speeds) {
    Path path({start_x, -kLaneCentre}, 0.0);
    scene.camera.drive = Drive(path.Straight(kLongMetres), 0.0, std::move(speeds));
  }

  // On the pavement, looking `yaw_radians` away from the walking direction.
  void WalkCamera(double start_x, double speed, double sway_radians, double yaw_radians) {
    Path path({start_x, -7.9}, 0.0);
    CameraRig& rig = scene.camera;
    rig.drive = Drive(path.Straight(kLongMetres), 0.0, {{0.0, speed}});
    rig.height_metres = 1.62 + kKerbHeight;
    rig.unevenness = 0.0;
    rig.sway_radians = sway_radians;
    rig.bob_metres = speed > 0.0 ? 0.025 : 0.0;
    rig.yaw_radians = yaw_radians;
  }

  double CameraX(double seconds) const { return scene.camera.drive.At(seconds).pose.position.x(); }

  // Time at which the camera's x passes `x`; the drive's duration if it does not.
  double CameraArrival(double x) const {
    for (double t = 0.0; t < duration; t += 0.1) {
      if (CameraX(t) >= x) return t;
    }
    return duration;
  }

  // --- Traffic. `x` is the mover's position at t = 0.
  void Add(ObjectClass object_class, Path path, double start, Speeds speeds, double ground = 0.0) {
    SceneObject object{object_class, Draw(2000u), scene.light.night,
                       Drive(std::move(path), start, std::move(speeds)), ground};
    if (IsClear(object)) scene.objects.push_back(std::move(object));
  }

  void Ahead(ObjectClass object_class, double x, Speeds speeds) {
    Add(object_class, Path({x, -kLaneCentre}, 0.0), 0.0, std::move(speeds));
  }

  void Oncoming(ObjectClass object_class, double x, Speeds speeds) {
    Add(object_class, Path({x, kLaneCentre}, M_PI), 0.0, std::move(speeds));
  }

  // In the oncoming lane, in the camera's direction; returns to the right lane `return_metres`
  // after the start if that is positive.
  void Overtaker(ObjectClass object_class, double x, double speed, double return_metres) {
    Path path({x, kLaneCentre}, 0.0);
    if (return_metres > 0.0) path.Shift(return_metres, return_metres + 22.0, -2.0 * kLaneCentre);
    Add(object_class, std::move(path), 0.0, {{0.0, speed}});
  }

  // Along the street x = i pitch, passing y = 0 at `seconds`; from the south for side = +1.
  void Crossing(ObjectClass object_class, int i, int side, double seconds, double speed) {
    Add(object_class, Path({i * kPitchX + side * kLaneCentre, 0.0}, side * M_PI / 2),
        -speed * seconds, {{0.0, speed}});
  }

  void Cyclist(double x, double speed, bool oncoming) {
    Add(ObjectClass::kCyclist, Path({x, oncoming ? 2.95 : -2.95}, oncoming ? M_PI : 0.0), 0.0,
        {{0.0, speed}});
  }

  // On the pavement of side +1 (north) or -1 (south), heading east for direction +1.
  void Walker(double x, int side, int direction, double speed, double across) {
    Add(ObjectClass::kPedestrian, Path({x, side * across}, direction > 0 ? 0.0 : M_PI), 0.0,
        {{0.0, speed}}, kKerbHeight);
  }

  // Crosses street j = 0 at x, from the south for side = +1: waits at the kerb, steps off at
  // `seconds` and stops on the other side.
  void CrossingWalker(double x, int side, double seconds, double speed) {
    const double there = seconds + (2.0 * kKerb + 1.2) / speed;
    Add(ObjectClass::kPedestrian, Path({x, -side * (kKerb + 0.6)}, side * M_PI / 2),
        std::max(0.0, -seconds) * speed,
        {{seconds - 0.3, 0.0}, {seconds, speed}, {there, speed}, {there + 0.3, 0.0}});
  }

  // People who cross the street ahead of the camera, one every `spacing_metres` of its path.
  void CrossingWalkers(double spacing_metres) {
    for (double x = CameraX(0.0) + 9.0; x < CameraX(duration);
         x += spacing_metres * Uniform(0.7, 1.3)) {
      // A walker from the right has left the camera's lane when the camera arrives; one from the
      // left has not reached it yet.
      const bool from_right = Chance(0.6);
      const double ahead = from_right ? Uniform(4.6, 5.6) : Uniform(2.0, 3.0);
      CrossingWalker(x, from_right ? 1 : -1, CameraArrival(x) - ahead, Uniform(1.3, 1.7));
    }
  }

  // Distributes walkers over both pavements, `per_100_metres` of them along the camera's path.
  void Walkers(double per_100_metres) {
    const double from = CameraX(0.0) - 10.0, to = CameraX(duration) + 70.0;
    const int count = static_cast<int>((to - from) * per_100_metres / 100.0);
    for (int k = 0; k < count; ++k) {
      const double x = Uniform(from, to), speed = Chance(0.15) ? 0.0 : Uniform(0.9, 1.7);
      const int side = Chance(0.5) ? 1 : -1, direction = Chance(0.5) ? 1 : -1;
      Walker(x, side, direction, speed, Uniform(7.0, 8.7));
    }
  }

  // Oncoming traffic at `speed`, with gaps of about `gap_metres`.
  void OncomingStream(double gap_metres, double speed) {
    const double end = CameraX(duration) + speed * duration + 60.0;
    for (double x = CameraX(0.0) + 18.0; x < end; x += gap_metres * Uniform(0.6, 1.6)) {
      Oncoming(Chance(0.2) ? kVan : kCar, x, {{0.0, speed}});
    }
  }

  // Cars that cross at every junction on the path, before and after the camera is near.
  void CrossingStream(double every_seconds, double speed) {
    const int first = static_cast<int>(std::ceil(CameraX(0.0) / kPitchX));
    const int last = static_cast<int>(std::ceil((CameraX(duration) + 60.0) / kPitchX));
    for (int i = first; i <= last; ++i) {
      const double arrival = CameraArrival(i * kPitchX - 12.0);
      for (double t = arrival - 9.0; t < std::min(arrival + 6.0, duration);
           t += every_seconds * Uniform(0.6, 1.5)) {
        const double kind = Uniform(0.0, 1.0);
        Crossing(kind < 0.12  ? kBus
                 : kind < 0.3 ? kVan
                              : kCar,
                 i, Chance(0.5) ? 1 : -1, t, speed * Uniform(0.85, 1.15));
      }
    }
  }

 private:
  bool IsClear(const SceneObject& candidate) const {
    const ObjectFacts& own = FactsOf(candidate.object_class);
    const double margin = own.half_width > 0.5 ? 0.25 : 0.1;
    for (double t = 0.0; t <= duration + 0.2; t += 0.2) {
      const DriveState state = candidate.drive.At(t);
      if (Gap(state, own, scene.camera.drive.At(t), FactsOf(kCar)) < margin + 0.1) return false;
      for (const SceneObject& other : scene.objects) {
        const DriveState there = other.drive.At(t);
        if ((there.pose.position - state.pose.position).squaredNorm() > 200.0) continue;
        if (Gap(state, own, there, FactsOf(other.object_class)) < margin) return false;
      }
    }
    return true;
  }

  const uint32_t seed_;
  uint32_t draws_ = 0;
};

namespace {

void Street(SceneBuilder& s) {
  s.DriveCamera(-36.0, {{0.0, 5.5}, {5.0, 5.0}, {8.0, 7.0}});
  s.scene.camera.bumps_metres = {24.0};
  s.CrossingStream(1.3, 8.0);
  s.CrossingWalkers(7.0);
  s.Ahead(kCar, -16.0, {{0.0, 6.0}, {5.0, 8.0}});
  s.OncomingStream(45.0, 8.0);
  s.Cyclist(-14.0, 3.6, false);
  s.Walkers(4.0);
}

void Junction(SceneBuilder& s) {
  s.DriveCamera(-18.0, {{0.0, 1.6}, {5.0, 1.2}});
  s.CrossingStream(1.5, 5.0);
  for (int k = 0; k < 8; ++k) {
    s.CrossingWalker(-7.5 + 0.3 * k, k % 2 == 0 ? 1 : -1, -5.0 + 1.6 * k, s.Uniform(1.2, 1.8));
  }
  s.OncomingStream(40.0, 7.0);
  s.Walkers(5.0);
}

// Twelve metres of bus, five to ten metres away.
void Buses(SceneBuilder& s) {
  s.DriveCamera(-15.0, {{0.0, 1.0}});
  for (double t = -6.0; t < s.duration + 6.0; t += s.Uniform(3.6, 4.4)) {
    s.Crossing(kBus, 0, -1, t, 4.0);
  }
  for (double t = -5.0; t < s.duration + 5.0; t += s.Uniform(3.2, 5.0)) {
    s.Crossing(s.Chance(0.6) ? kBus : kVan, 0, 1, t, 5.0);
  }
  s.Walkers(5.0);
}

void Crossing(SceneBuilder& s) {
  s.DriveCamera(-40.0, {{0.0, 4.5}});
  s.Crossing(kBus, 0, 1, 3.0, 7.0);
  s.CrossingStream(1.2, 8.0);
  for (double x = 14.0; x < 40.0; x += 8.0) s.Oncoming(kCar, x, {});  // wait at the stop line
  s.Walkers(3.0);
}

void Oncoming(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 9.0}});
  s.Oncoming(kBus, 40.0, {{0.0, 8.0}});
  s.OncomingStream(22.0, 10.0);
}

void Ahead(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 9.0}});
  // Falls back, keeps its distance, then pulls away.
  s.Ahead(kCar, -46.0, {{0.0, 9.0}, {2.0, 9.0}, {4.0, 7.6}, {5.0, 9.0}, {7.0, 9.0}, {9.0, 11.5}});
  s.Ahead(kVan, -26.0, {{0.0, 9.0}, {3.0, 10.0}});
}

void Overtaking(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 7.0}});
  s.Overtaker(kCar, -74.0, 13.0, 46.0);
  s.Overtaker(kVan, -98.0, 12.0, 0.0);
  s.Overtaker(kCar, -122.0, 13.0, 95.0);
  s.Cyclist(-44.0, 3.8, false);
  s.Cyclist(-22.0, 4.4, false);
}

void StandingTraffic(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 6.5}});
  for (double x = -46.0; x < 110.0; x += 7.2) s.Oncoming(x > 0 && x < 8.0 ? kVan : kCar, x, {});
  s.Ahead(kCar, 12.0, {{6.0, 0.0}, {9.0, 7.5}});
  s.Ahead(kBus, 24.0, {{5.0, 0.0}, {8.0, 8.0}});
  s.Walkers(5.0);
}

void StopAndGo(SceneBuilder& s) {
  s.DriveCamera(-52.0, {{0.0, 8.0}, {1.0, 8.0}, {4.2, 0.0}, {6.6, 0.0}, {9.5, 7.0}});
  s.Ahead(kCar, -41.0, {{0.0, 8.0}, {0.7, 8.0}, {3.9, 0.0}, {6.0, 0.0}, {8.6, 8.0}});
  s.CrossingStream(1.6, 8.5);
  s.CrossingWalker(-8.0, 1, 4.6, 1.5);
  s.CrossingWalker(-7.4, -1, 4.9, 1.4);
  s.OncomingStream(45.0, 8.0);
  s.Walkers(6.0);
}

void Pedestrians(SceneBuilder& s) {
  s.DriveCamera(-58.0, {{0.0, 5.0}});
  s.CrossingWalkers(4.0);
  s.CrossingWalker(-8.2, 1, 1.5, 1.4);
  s.CrossingWalker(-7.2, -1, 2.2, 1.3);
  s.Walkers(20.0);
}

void Turning(SceneBuilder& s) {
  constexpr double kStart = -42.0, kRadius = 9.0;
  Path path({kStart, -kLaneCentre}, 0.0);
  path.Straight(kLaneCentre - kRadius - kStart).Turn(kRadius, M_PI / 2).Straight(kLongMetres);
  s.scene.camera.drive =
      Drive(path, 0.0, {{0.0, 8.0}, {2.5, 8.0}, {4.5, 4.5}, {7.5, 4.5}, {9.5, 8.0}});
  s.CrossingStream(2.6, 8.0);
  s.OncomingStream(40.0, 8.0);
  s.Crossing(kCar, 0, -1, 8.0, 7.0);
  s.Walkers(8.0);
}

void Bus(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 7.0}});
  s.Ahead(kBus, -42.0, {{0.0, 7.5}, {3.0, 6.5}, {6.0, 8.0}});
  s.Oncoming(kBus, 30.0, {{0.0, 7.0}});
  s.Cyclist(-20.0, 5.0, true);
  s.Cyclist(-10.0, 4.5, true);
  s.Crossing(kBus, 1, -1, 6.0, 8.0);
  s.Walkers(6.0);
}

void Handheld(SceneBuilder& s) {
  s.WalkCamera(-40.0, 1.3, 0.10, 0.35);
  s.CrossingStream(2.5, 8.0);
  s.OncomingStream(26.0, 8.5);
  s.Ahead(kCar, -62.0, {{0.0, 9.0}});
  s.Ahead(kVan, -92.0, {{0.0, 9.0}});
  s.Ahead(kCar, -120.0, {{0.0, 9.0}});
  s.Cyclist(-52.0, 4.5, false);
  s.Walkers(12.0);
}

// Buses that crawl past at six metres. Only the houses above and between them are static.
void BusStop(SceneBuilder& s) {
  s.WalkCamera(-30.0, 1.4, 0.05, 1.05);
  for (int k = 0; k < 6; ++k) {
    s.Ahead(k % 3 == 1 ? kVan : kBus, -80.0 + 14.5 * k,
            {{0.0, 6.0}, {2.5, 3.0}, {4.0, 3.0}, {6.0, 7.0}, {8.0, 2.5}, {10.0, 5.0}});
  }
  s.OncomingStream(26.0, 8.0);
}

void Panning(SceneBuilder& s) {
  s.WalkCamera(-24.0, 0.0, 0.03, 1.1);
  s.scene.camera.pan_radians_per_second = -0.10;
  s.OncomingStream(22.0, 8.0);
  for (int k = 0; k < 5; ++k) s.Ahead(k == 2 ? kBus : kCar, -50.0 - 24.0 * k, {{0.0, 8.5}});
  s.Walkers(10.0);
}

void Walk(SceneBuilder& s) {
  s.WalkCamera(-40.0, 1.35, 0.05, 0.10);
  s.scene.camera.shake_radians = 0.006;
  s.scene.camera.shake_metres = 0.012;
  // Trunks and railings beside the path, within two metres of it.
  const double y = s.scene.camera.drive.At(0.0).pose.position.y();
  const double from = s.CameraX(0.0), to = s.CameraX(s.duration) + 25.0;
  for (double x = from + 1.5; x < to; x += s.Uniform(2.5, 5.0)) {
    const double side = s.Chance(0.5) ? -1.0 : 1.0;
    AppendTree({x, y + side * s.Uniform(0.9, 1.2), kKerbHeight}, s.Uniform(9.0, 13.0),
               s.Draw(3000u), &s.scene.scenery);
  }
  for (double x = from - 2.0; x < to; x += 9.0) {
    AppendRailing({x, y + 1.5, kKerbHeight}, {x + 7.5, y + 1.5, kKerbHeight}, &s.scene.scenery);
  }
  for (int k = 0; k < 6; ++k) {
    s.Walker(-34.0 + 5.0 * k, -1, k % 3 == 2 ? -1 : 1, s.Uniform(1.1, 1.9), s.Uniform(7.3, 8.4));
  }
  s.OncomingStream(30.0, 8.0);
  s.Ahead(kCar, -58.0, {{0.0, 8.0}});
  s.Ahead(kVan, -84.0, {{0.0, 8.5}});
  s.Cyclist(-50.0, 4.2, false);
}

void Cyclists(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 5.5}, {4.0, 4.6}});
  for (int k = 0; k < 10; ++k) {
    s.Cyclist(-52.0 + 11.0 * k + s.Uniform(0.0, 4.0), s.Uniform(3.6, 5.2), false);
  }
  s.Ahead(ObjectClass::kCyclist, -44.0, {{0.0, 4.7}, {6.0, 4.4}});
  s.Ahead(ObjectClass::kCyclist, -24.0, {{0.0, 4.5}});
  s.Ahead(ObjectClass::kPedestrian, -14.0, {{0.0, 2.6}});
  const double end = s.CameraX(s.duration) + 40.0;
  for (double x = -56.0; x < end; x += s.Uniform(5.0, 9.0)) {
    s.Walker(x, s.Chance(0.7) ? -1 : 1, 1, s.Uniform(1.0, 2.6), s.Uniform(6.2, 8.4));
  }
}

void Dashcam(SceneBuilder& s) {
  Street(s);
  s.scene.own_vehicle.visible = true;
}

void Clouds(SceneBuilder& s) {
  Street(s);
  s.scene.light.cloud_cover = 0.9;
  s.scene.light.wind = {14.0, 9.0};
  s.scene.lowest_house_metres = 12.0;
  s.scene.highest_house_metres = 36.0;
}

void Textureless(SceneBuilder& s) {
  Street(s);
  s.scene.ground.texture = 0.0f;
  s.scene.ground.markings = false;
  s.scene.texture = 0.25f;
}

void Night(SceneBuilder& s) {
  s.scene.light.night = true;
  s.scene.light.sky = Color(0.016f, 0.019f, 0.03f);
  s.scene.light.bounce = Color(0.012f, 0.011f, 0.01f);
  s.scene.sensor.exposure = 3.2;
  s.scene.sensor.read_noise = 0.012;
  s.scene.sensor.shot_noise = 0.025;
  s.scene.sensor.shutter_seconds = 0.012;
  Street(s);
}

// Round one block to the left again and again. The traffic of all rounds is alike: cars on all
// streets of the block, on each side, and people on the southern street's pavements.
void Rounds(SceneBuilder& s) {
  constexpr double kRoundSeconds = 45.0, kEverySeconds = 4.0, kPer100Metres = 6.0;
  constexpr double kRadius = 9.0, kQuarter = M_PI / 2, kSpeed = 8.0, kWalk = 1.3;
  const double width = kPitchX + 2.0 * kLaneCentre, depth = kPitchY + 2.0 * kLaneCentre;
  const double length = 2.0 * (width + depth) - 8.0 * kRadius + 2.0 * M_PI * kRadius;
  Path path({-kPitchX / 2, -kLaneCentre}, 0.0);
  for (double t = 0.0; t < s.duration + kRoundSeconds; t += kRoundSeconds) {
    path.Straight(width / 2 - kRadius).Turn(kRadius, kQuarter);
    path.Straight(depth - 2.0 * kRadius).Turn(kRadius, kQuarter);
    path.Straight(width - 2.0 * kRadius).Turn(kRadius, kQuarter);
    path.Straight(depth - 2.0 * kRadius).Turn(kRadius, kQuarter);
    path.Straight(width / 2 - kRadius);
  }
  s.scene.camera.drive = Drive(path, 0.0, {{0.0, length / kRoundSeconds}});
  const auto kind = [&] { return s.Chance(0.2) ? kVan : kCar; };
  const auto gap = [&] { return kEverySeconds * s.Uniform(0.6, 1.4); };
  for (const int street : {-1, 0}) {
    for (const int side : {-1, 1}) {
      for (double t = -8.0; t < s.duration + 8.0; t += gap()) {
        s.Crossing(kind(), street, side, t, kSpeed * s.Uniform(0.85, 1.15));
      }
    }
  }
  for (const double y : {kLaneCentre, kPitchY - kLaneCentre}) {  // against the camera's way
    const double heading = y < kPitchY / 2 ? M_PI : 0.0, forwards = heading > 0.0 ? -1.0 : 1.0;
    for (double t = -8.0; t < s.duration + 8.0; t += gap()) {
      s.Add(kind(), Path({-kPitchX / 2 - forwards * kSpeed * t, y}, heading), 0.0, {{0.0, kSpeed}});
    }
  }
  const double reach = kPitchX + kWalk * s.duration;
  for (int k = 0; k < static_cast<int>(2.0 * reach * kPer100Metres / 100.0); ++k) {
    const int side = s.Chance(0.5) ? 1 : -1, direction = s.Chance(0.5) ? 1 : -1;
    s.Walker(s.Uniform(-reach, reach) - kPitchX / 2, side, direction, kWalk, s.Uniform(7.0, 8.7));
  }
}

void Empty(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 9.0}});
  s.scene.camera.bumps_metres = {30.0};
  for (double x = 14.0; x < 40.0; x += 9.0) s.Oncoming(kCar, x, {});
}

}  // namespace

const std::vector<ScenarioDescription>& Scenarios() {
  static const auto* const scenarios = new std::vector<ScenarioDescription>{
      {"street", "a town drive: cars ahead, oncoming and crossing, a cyclist, people", Street},
      {"junction", "slowly up to a junction that cars and people cross", Junction},
      {"crossing", "towards a junction that cars and a bus cross", Crossing},
      {"buses", "slowly up to a junction where buses fill the picture", Buses},
      {"oncoming", "a stream of oncoming cars and a bus", Oncoming},
      {"ahead", "a car ahead in the lane: same speed, slower, faster", Ahead},
      {"overtaking", "cars overtake the camera, the camera overtakes cyclists", Overtaking},
      {"standing_traffic", "past a standing queue; two vehicles ahead start to move",
       StandingTraffic},
      {"stop_and_go", "the camera stops behind a car while others cross, and goes on", StopAndGo},
      {"pedestrians", "people on the pavements and across the road", Pedestrians},
      {"turning", "the camera turns left at a junction", Turning},
      {"bus", "buses ahead, oncoming and crossing; cyclists", Bus},
      {"handheld", "a camera in the hand of someone who walks", Handheld},
      {"bus_stop", "a camera in a hand, turned to the road: buses crawl past and fill the picture",
       BusStop},
      {"panning", "a camera that turns on the spot: no parallax", Panning},
      {"walk", "a shaking camera in a hand, close past trunks and railings", Walk},
      {"cyclists", "cyclists and people ahead, in the camera's own direction", Cyclists},
      {"dashcam", "street, with bonnet, bracket, time stamp and reflections in the windscreen",
       Dashcam},
      {"clouds", "fast clouds and tall houses change the light", Clouds},
      {"textureless", "a road without texture or markings, plain walls", Textureless},
      {"night", "street lamps and headlights, a noisy sensor", Night},
      {"rounds", "round one block, every 45 s by the same places among other traffic", Rounds},
      {"empty", "a drive on which nothing else moves", Empty},
  };
  return *scenarios;
}

Scene BuildScene(const ScenarioDescription& scenario, uint64_t seed, double duration_seconds) {
  SceneBuilder builder(seed, duration_seconds);
  scenario.build(builder);
  Scene& scene = builder.scene;
  std::vector<Eigen::Vector2d> points;
  for (double t = 0.0; t <= duration_seconds + 1.0; t += 1.0) {
    points.push_back(scene.camera.drive.At(t).pose.position);
  }
  AppendTown(points, &scene);
  return std::move(scene);
}

}  // namespace egosieve::vision
