// Contents of one synthetic drive: scenery, movable objects, the camera and the light. Plain data;
// a pure function of scenario, seed and options.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/synthetic/camera.h"
#include "vision/synthetic/drive.h"
#include "vision/synthetic/models.h"
#include "vision/synthetic/own_vehicle.h"
#include "vision/synthetic/primitive.h"
#include "vision/synthetic/surface.h"

namespace egosieve::vision {

struct LightSettings {
  Eigen::Vector3d to_sun = Eigen::Vector3d(0.35, -0.5, 0.79);  // unit
  Color sun = Color(2.7f, 2.5f, 2.15f);
  Color sky = Color(0.42f, 0.50f, 0.64f);            // ambient from above
  Color bounce = Color(0.24f, 0.21f, 0.18f);         // ambient from below
  double cloud_cover = 0.25;                         // largest share of sunlight lost in clouds
  Eigen::Vector2d wind = Eigen::Vector2d(4.0, 2.0);  // metres per second
  bool night = false;
};

struct SensorSettings {
  double shutter_seconds = 0.002;
  double read_noise = 0.004;    // of full scale, linear light
  double shot_noise = 0.010;    // deviation at full scale; grows with the root of the signal
  double exposure = 0.9;        // gain
  double exposure_swing = 0.0;  // amplitude of its logarithm; it varies within a second or two
};

struct Scene {
  std::vector<Primitive> scenery;
  std::vector<Eigen::Vector3d> lamps;  // positions of street lamps
  std::vector<SceneObject> objects;
  CameraRig camera;
  Intrinsics intrinsics;
  GroundStyle ground;
  float texture = 1.0f;  // contrast of walls and pavements
  double lowest_house_metres = 8.0, highest_house_metres = 24.0;
  LightSettings light;
  SensorSettings sensor;
  OwnVehicleStyle own_vehicle;
  uint32_t seed = 0;
};

}  // namespace egosieve::vision
