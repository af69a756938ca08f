// Drives through a synthetic town with exact truth: for every frame the picture, the pixels on
// movers, depth, the camera's pose and every object's motion.
//
// A frame is ray-cast (ray_caster.h); truth is taken where the ray through a pixel's centre meets
// the scene. Pixels whose neighbours see another surface or shadow are smoothed by four more rays;
// the others evaluate their texture at four points. Motion blur, lens, noise and response follow
// (street.cc). In a drive with its own vehicle in view (own_vehicle.h), the own vehicle's pixels are
// void in the mask. Shadows, also moving ones, belong to the surface that they fall on. A frame is
// a pure function of scenario, seed, options and its index; earlier frames and the number of
// threads have no influence.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/synthetic/camera.h"
#include "vision/synthetic/models.h"
#include "vision/synthetic/scene.h"

namespace egosieve::vision {

struct SceneIndex;

struct ScenarioOptions {
  int width_pixels = 640;
  int height_pixels = 360;
  int frames = 150;
  double frames_per_second = 10.0;
  double field_of_view_degrees = 75.0;  // horizontal, without distortion
  double radial = 0.0;                  // coefficient of the lens (camera.h); negative: barrel
                                        // distortion
  double exposure_swing = 0.0;          // amplitude of the logarithm of the exposure
  bool noise = true;
  bool motion_blur = true;
  int threads = 2;

  // InvalidArgument with field, value and rule.
  absl::Status Validate() const;
};

// An object's heading relative to the camera's: the direction of traffic from the driver's view.
enum class Relation {
  kStanding,
  kAhead,     // within 45 degrees of the camera's heading
  kOncoming,  // within 45 degrees of the opposite
  kCrossing,
};

const char* RelationName(Relation relation);

// An object that has at least one pixel in the frame.
struct ObjectState {
  int id = 0;  // as in SyntheticFrame::ids; the same in all frames
  ObjectClass object_class = ObjectClass::kCar;
  bool moving = false;  // faster than 0.05 m/s at this instant
  Relation relation = Relation::kStanding;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // world, its centre on the ground
  double heading_radians = 0.0;                        // world, from the x axis
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // world, metres per second
  Eigen::Vector3d relative_velocity =
      Eigen::Vector3d::Zero();   // camera axes, minus the camera's own
  double distance_metres = 0.0;  // from the camera to its centre
  int area_pixels = 0;
  cv::Rect box;  // around its pixels
};

struct SyntheticFrame {
  int index = 0;
  double seconds = 0.0;
  cv::Mat image;  // CV_8UC3, blue, green, red
  // CV_8UC1: 255 where the pixel's object moves at this instant, 128 on the own vehicle, else 0.
  cv::Mat mask;
  cv::Mat ids;          // CV_16UC1: object, 0 for scenery
  cv::Mat depth;        // CV_64FC1: Z of the scene in metres, also behind the own vehicle;
                        // infinite: sky
  cv::Mat own_vehicle;  // CV_8UC1: 255 at its pixels; empty if the drive shows none
  Pose pose;
  std::vector<ObjectState> objects;
};

class Scenario {
 public:
  Scenario(std::string name, uint64_t seed, const ScenarioOptions& options, Scene scene);

  const std::string& name() const { return name_; }
  uint64_t seed() const { return seed_; }
  const ScenarioOptions& options() const { return options_; }
  const Intrinsics& intrinsics() const { return scene_->intrinsics; }
  const Scene& scene() const { return *scene_; }
  Pose PoseAt(int frame) const;

  // OutOfRange unless 0 <= frame < options().frames.
  absl::StatusOr<SyntheticFrame> Render(int frame) const;

 private:
  std::string name_;
  uint64_t seed_;
  ScenarioOptions options_;
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const SceneIndex> index_;
  std::shared_ptr<const OwnVehicle> own_vehicle_;  // null: not in view
};

class SceneBuilder;  // scenario_catalogue.cc

struct ScenarioDescription {
  std::string_view name;
  std::string_view summary;  // one line
  void (*build)(SceneBuilder& scene);
};

// All scenarios, in the order for listings.
const std::vector<ScenarioDescription>& Scenarios();
std::vector<std::string> ScenarioNames();

Scene BuildScene(const ScenarioDescription& scenario, uint64_t seed, double duration_seconds);

// NotFound, with a list of the names, for an unknown name.
absl::StatusOr<Scenario> MakeScenario(std::string_view name, uint64_t seed,
                                      const ScenarioOptions& options = {});

}  // namespace egosieve::vision
