// Vocabulary for scenarios: the camera's drive and the traffic around it.
//
// The camera drives east (along x) on street j = 0. Seconds count from the first frame. A mover is
// added only if it keeps clear of the camera and of all movers added before it for the whole drive.
// Otherwise it is left out, so that crowded scenes stay plausible.
#pragma once

#include <cstdint>
#include <vector>

#include "vision/synthetic/scene.h"
#include "vision/synthetic/town.h"

namespace egosieve::vision {

class SceneBuilder {
 public:
  SceneBuilder(uint64_t seed, double duration_seconds);

  Scene scene;       // light, sensor and textures may be set directly
  TownOptions town;  // likewise; used by Finish

  double duration() const { return duration_; }
  // Uniform in [low, high), from the seed.
  double Uniform(double low, double high);

  // --- Camera. Call one of these first.
  void DriveCamera(double start_x, std::vector<SpeedKey> keys);
  // Turns left (+1) or right (-1) at the junction with x = 0.
  void TurnCamera(double start_x, int side, std::vector<SpeedKey> keys);
  // Drives round one block to the left again and again, `round_seconds` per round.
  void RoundCamera(double round_seconds);
  // On the pavement, looking `yaw_radians` away from the walking direction.
  void WalkCamera(double start_x, double speed, double sway_radians, double yaw_radians);

  // Trunks and railings beside a walking camera's path, within two metres of it.
  void LineTheWay();

  double CameraX(double seconds) const;
  // Time at which the camera's x passes `x`; the drive's duration if it does not.
  double CameraArrival(double x) const;

  // --- Traffic. `x` is the mover's position at t = 0.
  void Ahead(ObjectClass object_class, double x, std::vector<SpeedKey> keys);
  void Oncoming(ObjectClass object_class, double x, std::vector<SpeedKey> keys);
  // In the oncoming lane, in the camera's direction; returns to the right lane `return_metres`
  // after the start if that is positive.
  void Overtaker(ObjectClass object_class, double x, double speed, double return_metres);
  // Along the street x = i pitch, passing y = 0 at `seconds`; from the south for side = +1.
  void Crossing(ObjectClass object_class, int i, int side, double seconds, double speed);
  void Cyclist(double x, double speed, bool oncoming);
  // On the pavement of side +1 (north) or -1 (south), heading east for direction +1.
  void Walker(double x, int side, int direction, double speed, double across = 7.6);
  // Crosses street j = 0 at x, stepping off at `seconds`, from the south for side = +1.
  void CrossingWalker(double x, int side, double seconds, double speed);

  // People who cross the street ahead of the camera, one every `spacing_metres` of its path.
  void CrossingWalkers(double spacing_metres);
  // Distributes walkers over both pavements, `per_100_metres` of them along the camera's path.
  void Walkers(double per_100_metres);
  // Oncoming traffic at `speed`, with gaps of about `gap_metres`.
  void OncomingStream(double gap_metres, double speed);
  // Traffic for RoundCamera, for the whole drive, on all streets of its block, and the same in
  // every round: cars every `every_seconds` on each side, and people on the southern street's
  // pavements.
  void TrafficRound(double every_seconds, double walkers_per_100_metres);
  // Cars that cross at every junction on the path, before and after the camera is near.
  void CrossingStream(double every_seconds, double speed);

  Scene Finish();

 private:
  bool Clear(const SceneObject& candidate) const;
  void Add(ObjectClass object_class, Path path, double start, std::vector<SpeedKey> keys,
           double ground);

  uint32_t seed_;
  uint32_t draws_ = 0;
  double duration_;
};

}  // namespace egosieve::vision
