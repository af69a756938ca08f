// Models of street objects, built of primitives. Each stands on z = 0 of its own frame, x forward,
// y to the left, and is placed by world = Rz(yaw) local + position.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/synthetic/drive.h"
#include "vision/synthetic/primitive.h"

namespace egosieve::vision {

enum class ObjectClass { kCar, kVan, kBus, kPedestrian, kCyclist };

struct ObjectFacts {
  const char* name;
  double half_length, half_width;  // of the footprint, metres
};

const ObjectFacts& FactsOf(ObjectClass object_class);

// An object that can move.
struct SceneObject {
  ObjectClass object_class = ObjectClass::kCar;
  uint32_t seed = 0;  // of its looks
  bool lights_on = false;
  Drive drive;
  double ground_metres = 0.0;  // height of the ground below it
};

// Appends the model's primitives where `state` of its drive puts it, all with the index `object`.
// The way travelled turns wheels and swings limbs.
void AppendModel(const SceneObject& model, const DriveState& state, int object,
                 std::vector<Primitive>* primitives);

void AppendTree(const Eigen::Vector3d& foot, double height, uint32_t seed,
                std::vector<Primitive>* primitives);
void AppendLamp(const Eigen::Vector3d& foot, double yaw_radians, bool lights_on,
                std::vector<Primitive>* primitives);
void AppendSign(const Eigen::Vector3d& foot, double yaw_radians, uint32_t seed,
                std::vector<Primitive>* primitives);

// A railing of upright bars between two points on the ground.
void AppendRailing(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                   std::vector<Primitive>* primitives);

// A usual colour of clothes.
Color ClothColor(uint32_t seed);

}  // namespace egosieve::vision
