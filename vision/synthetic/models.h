// Models of street objects, built of primitives. Each stands on z = 0 of its own frame, x forward,
// y to the left, and is placed by a rigid motion of the plane.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/synthetic/primitive.h"

namespace egosieve::vision {

enum class ObjectClass { kCar, kVan, kBus, kPedestrian, kCyclist };

const char* ObjectClassName(ObjectClass object_class);

// Position and heading of a model: world = Rz(yaw) local + position.
struct Placement {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double yaw_radians = 0.0;
};

struct ModelLook {
  ObjectClass object_class = ObjectClass::kCar;
  uint32_t seed = 0;
  bool lights_on = false;
};

// Appends the model's primitives, all with the index `object`. `travelled_metres` turns wheels and
// swings limbs; a model looks the same as long as it is unchanged.
void AppendModel(const ModelLook& look, const Placement& placement, double travelled_metres,
                 int object, std::vector<Primitive>* primitives);

// The half extents of the model's footprint, metres: along and across.
Eigen::Vector2d ModelHalfExtent(ObjectClass object_class);

void AppendTree(const Eigen::Vector3d& foot, double height, uint32_t seed,
                std::vector<Primitive>* primitives);
void AppendLamp(const Eigen::Vector3d& foot, double yaw_radians, bool lights_on,
                std::vector<Primitive>* primitives);
void AppendSign(const Eigen::Vector3d& foot, double yaw_radians, uint32_t seed,
                std::vector<Primitive>* primitives);

// A railing of upright bars between two points on the ground.
void AppendRailing(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                   std::vector<Primitive>* primitives);

// PaintColor: a usual colour of cars; ClothColor: a usual colour of clothes.
Color PaintColor(uint32_t seed);
Color ClothColor(uint32_t seed);

}  // namespace egosieve::vision
