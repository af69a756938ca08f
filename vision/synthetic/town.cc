#include "vision/synthetic/town.h"

#include <Eigen/Geometry>
#include <cmath>
#include <set>
#include <utility>

#include "vision/synthetic/noise.h"

namespace egosieve::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kReachMetres = 150.0;  // around the points that the camera passes
constexpr double kParked = 0.55;        // share of parking bays with a car
constexpr double kTrees = 0.75;         // share of tree places with a tree
constexpr double kDepth = 12.0;         // metres, of houses

Color WallColor(uint32_t seed) {
  static constexpr float kWalls[][3] = {
      {0.42f, 0.36f, 0.27f}, {0.33f, 0.17f, 0.12f}, {0.45f, 0.42f, 0.38f}, {0.38f, 0.28f, 0.16f},
      {0.30f, 0.32f, 0.33f}, {0.40f, 0.25f, 0.19f}, {0.48f, 0.45f, 0.33f}, {0.27f, 0.30f, 0.27f}};
  const float* c = kWalls[Hash(seed + 71) % 8];
  return Color(c[0], c[1], c[2]) * (0.8f + 0.4f * Unit(Hash(seed + 72)));
}

// One edge of a block: positions (along, outwards) map to the world.
struct Edge {
  Vector2d corner;    // where `along` = 0 meets the house line
  Vector2d along;     // unit
  Vector2d outwards;  // unit, towards the street
  double length;
  Vector3d At(double a, double o, double z) const {
    const Vector2d p = corner + a * along + o * outwards;
    return {p.x(), p.y(), z};
  }
  double Yaw() const { return std::atan2(outwards.y(), outwards.x()); }
};

class TownBuilder {
 public:
  explicit TownBuilder(Scene* scene) : seed_(Hash(scene->seed + 3)), scene_(scene) {}

  void AddBlock(int i, int j) {
    const uint32_t seed = Hash(seed_, i, j);
    const double x0 = i * kPitchX, x1 = x0 + kPitchX, y0 = j * kPitchY, y1 = y0 + kPitchY;
    AddBox({x0 + kKerb, y0 + kKerb, -0.5}, {x1 - kKerb, y1 - kKerb, kKerbHeight},
           {Material::kPavement, seed_ + 5, Color(0.34f, 0.33f, 0.31f)});
    const double hx0 = x0 + kHouseLine, hx1 = x1 - kHouseLine, hy0 = y0 + kHouseLine,
                 hy1 = y1 - kHouseLine;
    const Edge edges[] = {{{hx0, hy0}, {1, 0}, {0, -1}, hx1 - hx0},
                          {{hx1, hy1}, {-1, 0}, {0, 1}, hx1 - hx0},
                          {{hx1, hy0}, {0, 1}, {1, 0}, hy1 - hy0},
                          {{hx0, hy1}, {0, -1}, {-1, 0}, hy1 - hy0}};
    for (int e = 0; e < 4; ++e) {
      const bool full = e < 2;  // the other two lie between the houses of the first two
      AddHouses(edges[e], full ? 0.0 : kDepth, full ? edges[e].length : edges[e].length - kDepth,
                Hash(seed + e));
      AddStreetFurniture(edges[e], Hash(seed + 10 + e));
    }
    const uint32_t parked = Hash(seed_ + 99, i, j);
    AddParkedCars({x0, y0}, Vector2d::UnitX(), kPitchX, parked);
    AddParkedCars({x0, y0}, Vector2d::UnitY(), kPitchY, parked + 1);
  }

 private:
  // Bays on both sides of the street between two junctions.
  void AddParkedCars(const Vector2d& from, const Vector2d& along, double length, uint32_t seed) {
    const Vector2d left(-along.y(), along.x());
    const int bays = static_cast<int>((length - 30.0) / 5.6);
    for (int side = 0; side < 2; ++side) {
      for (int bay = 0; bay < bays; ++bay) {
        const uint32_t h = Hash(seed, side, bay);
        if (!(Unit(h) < kParked)) continue;
        SceneObject car;
        car.object_class = Unit(Hash(h + 1)) < 0.15f ? ObjectClass::kVan : ObjectClass::kCar;
        car.seed = Hash(h + 2);
        const double across =
            (side == 0 ? -1.0 : 1.0) * (kParkingCentre + 0.1 * (Unit(Hash(h + 3)) - 0.5));
        const double s = 16.5 + 5.6 * bay + 0.7 * (Unit(Hash(h + 4)) - 0.5);
        const double heading = std::atan2(along.y(), along.x()) + (side == 0 ? 0.0 : M_PI);
        const double askew = 0.03 * (Unit(Hash(h + 5)) - 0.5);
        car.drive = Drive(Path(from + s * along + across * left, heading + askew), 0.0, {});
        scene_->objects.push_back(std::move(car));
      }
    }
  }

  // Between two opposite corners.
  void AddBox(const Vector3d& a, const Vector3d& b, const Appearance& appearance) {
    Primitive box;
    const Vector3d low = a.cwiseMin(b), high = a.cwiseMax(b);
    box.origin = 0.5 * (low + high);
    box.half_size = 0.5 * (high - low);
    box.appearance = appearance;
    scene_->scenery.push_back(std::move(box));
  }

  void AddHouses(const Edge& edge, double from, double to, uint32_t seed) {
    double a = from;
    for (int lot = 0; a < to - 1.0; ++lot) {
      const uint32_t h = Hash(seed, lot);
      double width = 8.0 + 8.0 * Unit(h);
      if (to - a - width < 7.0) width = to - a;
      if (Unit(Hash(h + 1)) < 0.12f && a > from && a + width < to) {
        AddGarden(edge, a, width, h);
      } else {
        AddHouse(edge, a, width, h);
      }
      a += width;
    }
  }

  void AddHouse(const Edge& edge, double a, double width, uint32_t seed) {
    const double t = Unit(Hash(seed + 2));
    const double low = scene_->lowest_house_metres, high = scene_->highest_house_metres;
    const double height = low + (high - low) * t * (0.5 + 0.5 * t);
    const double recess = 0.35 * Unit(Hash(seed + 3));
    const Color color = WallColor(seed);
    AddBox(edge.At(a, -kDepth, 0.0), edge.At(a + width, -recess, height),
           {Material::kFacade, seed, color, scene_->light.night});
    if (height < 13.0 && Unit(Hash(seed + 4)) < 0.7f) AddRoof(edge, a, width, height, seed);
    const int balconies = Unit(Hash(seed + 5)) < 0.35f ? static_cast<int>((height - 4.5) / 3.0) : 0;
    for (int k = 0; k < balconies; ++k) {
      const double place = a + 1.2 + (width - 4.4) * Unit(Hash(seed + 50 + k / 2));
      AddBox(edge.At(place, -0.4, 3.9 + 3.0 * k), edge.At(place + 2.2, 0.9, 4.9 + 3.0 * k),
             {Material::kCloth, seed + 6, color * 0.8f});
    }
    if (Unit(Hash(seed + 7)) < 0.3f) {  // an awning over the shop
      AddBox(edge.At(a + 0.6, -0.4, 2.75), edge.At(a + 0.6 * width, 1.3, 2.95),
             {Material::kCloth, seed + 8, ClothColor(seed + 8)});
    }
  }

  void AddRoof(const Edge& edge, double a, double width, double height, uint32_t seed) {
    const double rise = 2.2 + 1.8 * Unit(Hash(seed + 9)), half = kDepth / 2 + 0.3;
    Primitive roof;
    roof.shape = Shape::kProfile;
    roof.profile = MakeProfile({{-half, 0.0}, {half, 0.0}, {0.0, rise}}, width / 2 + 0.05, 0.0);
    roof.half_size = roof.profile->half_size;
    roof.rotation = Eigen::AngleAxisd(edge.Yaw(), Vector3d::UnitZ()).toRotationMatrix();
    roof.origin = edge.At(a + width / 2, -kDepth / 2, height);
    const float red = Unit(Hash(seed + 10));
    roof.appearance = {Material::kRoof, seed,
                       Color(0.14f + 0.14f * red, 0.11f + 0.03f * red, 0.1f)};
    scene_->scenery.push_back(std::move(roof));
  }

  void AddGarden(const Edge& edge, double a, double width, uint32_t seed) {
    const Color color = Unit(Hash(seed + 3)) < 0.5f ? Color(0.07f, 0.14f, 0.04f)  // a hedge
                                                    : WallColor(seed);
    AddBox(edge.At(a, -0.35, 0.0), edge.At(a + width, 0.0, 1.3 + 0.8 * Unit(Hash(seed + 2))),
           {Material::kBark, seed, color});
    AppendTree(edge.At(a + width / 2, -5.0, 0.0), 7.0 + 4.0 * Unit(Hash(seed + 4)), seed + 5,
               &scene_->scenery);
    AddBox(edge.At(a, -kDepth, 0.0), edge.At(a + width, -kDepth - 6.0, 6.0),
           {Material::kFacade, seed + 6, WallColor(seed + 6), scene_->light.night});
  }

  void AddStreetFurniture(const Edge& edge, uint32_t seed) {
    const double row = kHouseLine - kKerb - 0.7;  // trees and posts stand near the kerb
    for (int k = 0; 6.0 + 11.0 * k < edge.length - 4.0; ++k) {
      const uint32_t h = Hash(seed, k);
      const double a = 5.0 + 11.0 * k + 3.0 * Unit(h);
      if (Unit(Hash(h + 1)) < kTrees) {
        AppendTree(edge.At(a, row, kKerbHeight), 5.0 + 3.5 * Unit(Hash(h + 2)), Hash(h + 3),
                   &scene_->scenery);
      }
      if (k % 2 == 0) {
        const Vector3d foot = edge.At(a + 4.5, row + 0.3, kKerbHeight);
        AppendLamp(foot, edge.Yaw(), scene_->light.night, &scene_->scenery);
        scene_->lamps.push_back(edge.At(a + 4.5, row + 1.7, 5.9));
      }
      const float what = Unit(Hash(h + 4));
      if (what < 0.3f) {
        const double turn = edge.Yaw() + (Unit(Hash(h + 5)) < 0.5f ? 0.5 : -0.5) * M_PI;
        AppendSign(edge.At(a + 2.2, row, kKerbHeight), turn, Hash(h + 6), &scene_->scenery);
      } else if (what < 0.6f) {  // bins, boxes, planters
        const double s = 0.25 + 0.3 * Unit(Hash(h + 7));
        AddBox(edge.At(a + 2.0, row - 0.2, kKerbHeight),
               edge.At(a + 2.0 + 2.0 * s, row - 0.2 - s, kKerbHeight + 0.6 + s),
               {Material::kCloth, h, ClothColor(h)});
      }
    }
  }

  const uint32_t seed_;
  Scene* scene_;
};

}  // namespace

void AppendTown(const std::vector<Vector2d>& camera_points, Scene* scene) {
  std::set<std::pair<int, int>> blocks;
  const auto block = [](double at, double pitch) {
    return static_cast<int>(std::floor(at / pitch));
  };
  for (const Vector2d& point : camera_points) {
    const Vector2d low = point.array() - kReachMetres, high = point.array() + kReachMetres;
    for (int i = block(low.x(), kPitchX); i <= block(high.x(), kPitchX); ++i) {
      for (int j = block(low.y(), kPitchY); j <= block(high.y(), kPitchY); ++j) {
        blocks.emplace(i, j);
      }
    }
  }
  TownBuilder builder(scene);
  for (const auto& [i, j] : blocks) builder.AddBlock(i, j);
}

}  // namespace egosieve::vision
