#include "vision/synthetic/models.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "vision/synthetic/noise.h"

namespace egosieve::vision {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d Turn(double radians, const Vector3d& axis) {
  return AngleAxisd(radians, axis).toRotationMatrix();
}

// Collects the parts of one model and places them in the world.
struct Assembly {
  double yaw_radians;
  Vector3d position;
  int object;
  std::vector<Primitive>* primitives;

  Primitive& Add(Shape shape, const Vector3d& centre, const Vector3d& half_size,
                 const Appearance& appearance, const Matrix3d& rotation = Matrix3d::Identity()) {
    const Matrix3d turn = Turn(yaw_radians, Vector3d::UnitZ());
    return primitives->emplace_back(Primitive{shape, turn * rotation, turn * centre + position,
                                              half_size, nullptr, appearance, object});
  }

  void AddProfile(const std::shared_ptr<const Profile>& profile, const Vector3d& centre,
                  const Appearance& appearance) {
    Add(Shape::kProfile, centre, profile->half_size, appearance).profile = profile;
  }

  // A round limb or bar from `a` to `b`.
  void AddLimb(const Vector3d& a, const Vector3d& b, double radius, Shape shape,
               const Appearance& appearance) {
    const Vector3d along = b - a;
    Add(shape, 0.5 * (a + b), Vector3d(radius, radius, 0.5 * along.norm()), appearance,
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), along.normalized())
            .toRotationMatrix());
  }

  void AddWheel(const Vector3d& centre, double radius, double half_width, double travelled,
                const Appearance& appearance) {
    Add(Shape::kCylinder, centre, Vector3d(radius, radius, half_width), appearance,
        Turn(-M_PI / 2, Vector3d::UnitX()) * Turn(travelled / radius, Vector3d::UnitZ()));
  }
};

void AppendWheels(const std::vector<double>& axles, double track, double radius, double travelled,
                  uint32_t seed, Assembly* model) {
  for (const double axle : axles) {
    for (const double side : {-1.0, 1.0}) {
      model->AddWheel({axle, side * track, radius}, radius, 0.11, travelled,
                      {Material::kWheel, seed, Color::Zero()});
    }
  }
}

// A usual colour of cars.
Color PaintColor(uint32_t seed) {
  static constexpr float kPaints[][3] = {
      {0.62f, 0.62f, 0.6f},  {0.05f, 0.05f, 0.055f}, {0.30f, 0.31f, 0.33f},
      {0.45f, 0.03f, 0.03f}, {0.03f, 0.08f, 0.3f},   {0.13f, 0.14f, 0.15f},
      {0.06f, 0.2f, 0.11f},  {0.5f, 0.42f, 0.25f},   {0.1f, 0.25f, 0.42f}};
  const float* c = kPaints[Hash(seed + 17) % 9];
  return Color(c[0], c[1], c[2]);
}

void AppendCar(const SceneObject& look, double travelled, Assembly* model) {
  using Points = std::vector<Eigen::Vector2d>;
  static const Points body_points = {{-2.10, -0.30}, {2.08, -0.30}, {2.14, -0.05}, {2.02, 0.16},
                                     {1.0, 0.30},    {-1.75, 0.32}, {-2.12, 0.2}};
  static const Points cabin_points = {{-1.50, -0.29}, {1.28, -0.29}, {0.45, 0.28}, {-1.05, 0.29}};
  static const Points van_points = {{-1.62, -0.47}, {1.34, -0.47}, {0.75, 0.46}, {-1.60, 0.47}};
  // Shared by all cars and built once.
  static const auto body = MakeProfile(body_points, 0.86, 0.04);
  static const auto cabin = MakeProfile(cabin_points, 0.71, 0.22);
  static const auto van_cabin = MakeProfile(van_points, 0.76, 0.06);
  const bool van = look.object_class == ObjectClass::kVan;
  const Color paint = PaintColor(look.seed);
  model->AddProfile(body, {0.0, 0.0, 0.57}, {Material::kCarBody, look.seed, paint, look.lights_on});
  model->AddProfile(van ? van_cabin : cabin, {-0.15, 0.0, van ? 1.33 : 1.16},
                    {Material::kCarCabin, look.seed, paint});
  AppendWheels({-1.33, 1.33}, 0.78, 0.32, travelled, look.seed, model);
}

void AppendBus(const SceneObject& look, double travelled, Assembly* model) {
  const Color paint = Unit(look.seed) < 0.5f ? Color(0.5f, 0.06f, 0.05f) : Color(0.55f, 0.5f, 0.1f);
  model->Add(Shape::kBox, {0.0, 0.0, 1.7}, {5.6, 1.25, 1.35},
             {Material::kBus, look.seed, paint, look.lights_on});
  AppendWheels({-3.3, 3.6}, 1.16, 0.47, travelled, look.seed, model);
}

void AppendPerson(uint32_t s, const Vector3d& hip, double lean, double stride_radians, bool cycling,
                  Assembly* model) {
  const Color skin = Color(0.52f, 0.33f, 0.23f) * (0.35f + 0.75f * Unit(Hash(s + 1)));
  const Appearance trousers{Material::kCloth, s + 2, ClothColor(s + 2) * 0.6f};
  const Appearance jacket{Material::kCloth, s + 3, ClothColor(s + 3)};
  const Appearance bare{Material::kSkin, s + 4, skin};
  const Appearance hair{Material::kSkin, s + 5,
                        Color(0.1f, 0.07f, 0.05f) * (0.4f + 1.8f * Unit(Hash(s + 5)))};
  const Vector3d up(std::sin(lean), 0.0, std::cos(lean));
  const Vector3d shoulder = hip + 0.52 * up;
  model->Add(Shape::kEllipsoid, hip + 0.27 * up, {0.15, 0.24, 0.37}, jacket,
             Turn(lean, Vector3d::UnitY()));
  const Vector3d head = hip + 0.74 * up + Vector3d(cycling ? 0.05 : 0.0, 0.0, 0.0);
  model->Add(Shape::kEllipsoid, head, {0.10, 0.085, 0.125}, bare);
  model->Add(Shape::kEllipsoid, head + Vector3d(-0.02, 0.0, 0.035), {0.105, 0.095, 0.11}, hair);
  for (const double side : {-1.0, 1.0}) {
    const double swing = std::sin(stride_radians + (side > 0.0 ? M_PI : 0.0));
    const double lift = std::cos(stride_radians + (side > 0.0 ? M_PI : 0.0));
    const Vector3d joint = hip + Vector3d(0.0, 0.1 * side, 0.0);
    Vector3d knee =
        joint + 0.44 * Vector3d(std::sin(0.45 * swing + 0.12), 0.0, -std::cos(0.45 * swing + 0.12));
    Vector3d foot = knee + 0.44 * Vector3d(std::sin(0.5 * swing - 0.2 * std::max(0.0, lift) - 0.08),
                                           0.0, -std::cos(0.5 * swing - 0.2));
    if (cycling) {
      foot = Vector3d(0.17 * std::cos(stride_radians + side * M_PI / 2), 0.1 * side,
                      0.3 + 0.17 * std::sin(stride_radians + side * M_PI / 2));
      knee = 0.5 * (joint + foot) + Vector3d(0.17, 0.0, 0.06);
    }
    model->AddLimb(joint, knee, 0.085, Shape::kEllipsoid, trousers);
    model->AddLimb(knee, foot, 0.06, Shape::kEllipsoid, trousers);
    const Vector3d arm = shoulder + Vector3d(0.0, 0.23 * side, -0.04);
    const double reach = cycling ? 1.15 : -0.5 * swing;
    const Vector3d hand = arm + 0.58 * Vector3d(std::sin(reach), 0.0, -std::cos(reach));
    model->AddLimb(arm, hand, 0.055, Shape::kEllipsoid, jacket);
  }
}

void AppendCyclist(const SceneObject& look, double travelled, Assembly* model) {
  constexpr double kRadius = 0.34;
  const Appearance spokes{Material::kSpokes, look.seed, Color(0.05f, 0.05f, 0.05f)};
  const Appearance tube{Material::kMetal, look.seed + 1, ClothColor(look.seed + 9)};
  for (const double axle : {-0.52, 0.52})
    model->AddWheel({axle, 0.0, kRadius}, kRadius, 0.025, travelled, spokes);
  const Vector3d saddle(-0.2, 0.0, 0.92), crank(0.0, 0.0, 0.3), bars(0.42, 0.0, 0.98),
      rear(-0.52, 0.0, kRadius), front(0.52, 0.0, kRadius);
  for (const auto& [a, b] : {std::pair{saddle, crank},
                             {crank, bars},
                             {saddle, bars},
                             {saddle, rear},
                             {crank, rear},
                             {bars, front}}) {
    model->AddLimb(a, b, 0.025, Shape::kCylinder, tube);
  }
  AppendPerson(look.seed, saddle + Vector3d(0.0, 0.0, 0.06), 0.5, travelled / 0.8, true, model);
}

}  // namespace

const ObjectFacts& FactsOf(ObjectClass object_class) {
  static constexpr ObjectFacts kFacts[] = {{"car", 2.15, 0.9},
                                           {"van", 2.15, 0.9},
                                           {"bus", 5.6, 1.3},
                                           {"pedestrian", 0.4, 0.35},
                                           {"cyclist", 0.9, 0.4}};
  return kFacts[static_cast<int>(object_class)];
}

Color ClothColor(uint32_t seed) {
  const float hue = 6.2832f * Unit(Hash(seed)), value = 0.08f + 0.4f * Unit(Hash(seed + 1));
  return value *
         (1.0f + 0.55f * Color(std::cos(hue), std::cos(hue - 2.0944f), std::cos(hue + 2.0944f)));
}

void AppendModel(const SceneObject& model, const DriveState& state, int object,
                 std::vector<Primitive>* primitives) {
  Vector3d position;
  position << state.pose.position, model.ground_metres;
  Assembly parts{state.pose.heading_radians, position, object, primitives};
  const double travelled = state.travelled;
  switch (model.object_class) {
    case ObjectClass::kCar:
    case ObjectClass::kVan:
      return AppendCar(model, travelled, &parts);
    case ObjectClass::kBus:
      return AppendBus(model, travelled, &parts);
    case ObjectClass::kPedestrian:
      return AppendPerson(model.seed, {0.0, 0.0, 0.93 + 0.015 * std::cos(9.0 * travelled)}, 0.04,
                          4.3 * travelled, false, &parts);
    case ObjectClass::kCyclist:
      return AppendCyclist(model, travelled, &parts);
  }
}

void AppendTree(const Eigen::Vector3d& foot, double height, uint32_t seed,
                std::vector<Primitive>* primitives) {
  Assembly tree{6.2832 * Unit(seed), foot, -1, primitives};
  const double trunk = 0.45 * height, spread = 0.23 * height;
  tree.Add(Shape::kCylinder, {0, 0, trunk / 2}, {0.02 * height, 0.02 * height, trunk / 2},
           {Material::kBark, seed, Color(0.16f, 0.12f, 0.09f)});
  const float tint = Unit(Hash(seed + 2));
  const Color leaves(0.12f + 0.10f * tint, 0.23f + 0.07f * tint, 0.05f);
  constexpr int kClumps = 8;
  for (int k = 0; k < kClumps; ++k) {
    const uint32_t h = Hash(seed + 10, k);
    const double level = (k + 0.5) / kClumps;  // 0 below, 1 at the top
    const double angle = 2.4 * k + 1.5 * Unit(h);
    const double out = spread * (0.75 - 0.65 * level) * (0.7 + 0.5 * Unit(Hash(h + 1)));
    const double size = spread * (0.62 - 0.15 * level) * (0.75 + 0.5 * Unit(Hash(h + 2)));
    const Vector3d centre(out * std::cos(angle), out * std::sin(angle),
                          trunk + spread * (0.1 + 1.5 * level));
    tree.Add(Shape::kEllipsoid, centre, {size, size * (0.8 + 0.3 * Unit(Hash(h + 3))), 0.75 * size},
             {Material::kFoliage, h, leaves * (0.75f + 0.5f * Unit(Hash(h + 4)))});
  }
}

void AppendLamp(const Eigen::Vector3d& foot, double yaw_radians, bool lights_on,
                std::vector<Primitive>* primitives) {
  Assembly lamp{yaw_radians, foot, -1, primitives};
  const Appearance steel{Material::kMetal, 5, Color(0.14f, 0.15f, 0.14f)};
  lamp.Add(Shape::kCylinder, {0, 0, 2.9}, {0.07, 0.07, 2.9}, steel);
  lamp.AddLimb({0, 0, 5.75}, {1.3, 0, 6.0}, 0.05, Shape::kCylinder, steel);
  lamp.Add(Shape::kBox, {1.4, 0, 5.97}, {0.3, 0.12, 0.06},
           {Material::kLamp, 6, Color(0.6f, 0.6f, 0.55f), lights_on});
}

void AppendRailing(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                   std::vector<Primitive>* primitives) {
  constexpr double kHeight = 1.05, kSpacing = 0.2;
  Assembly railing{0.0, Vector3d::Zero(), -1, primitives};
  const Appearance steel{Material::kMetal, 9, Color(0.07f, 0.09f, 0.08f)};
  const Vector3d up(0.0, 0.0, kHeight);
  for (const double level : {0.15, 1.0}) {
    railing.AddLimb(from + level * up, to + level * up, 0.025, Shape::kCylinder, steel);
  }
  const int bars = static_cast<int>((to - from).norm() / kSpacing);
  for (int k = 0; k <= bars; ++k) {
    const Vector3d foot = from + (to - from) * (static_cast<double>(k) / std::max(bars, 1));
    railing.AddLimb(foot, foot + up, k % 10 == 0 ? 0.03 : 0.01, Shape::kCylinder, steel);
  }
}

void AppendSign(const Eigen::Vector3d& foot, double yaw_radians, uint32_t seed,
                std::vector<Primitive>* primitives) {
  Assembly sign{yaw_radians, foot, -1, primitives};
  sign.Add(Shape::kCylinder, {0, 0, 1.3}, {0.035, 0.035, 1.3},
           {Material::kMetal, 7, Color(0.3f, 0.3f, 0.3f)});
  const Color face = Unit(seed) < 0.5f ? Color(0.04f, 0.1f, 0.4f) : Color(0.4f, 0.03f, 0.03f);
  sign.Add(Shape::kBox, {-0.06, 0, 2.35}, {0.015, 0.34, 0.34}, {Material::kSign, seed, face});
}

}  // namespace egosieve::vision
