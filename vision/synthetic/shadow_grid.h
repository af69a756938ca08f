// Finds the primitives that may lie between a point and the sun.
//
// A primitive shades the point P only if the line through P along the sun's direction meets its
// bounding box; that line meets the ground at
//
//   (SG1) G = P - to_sun P_z / to_sun_z
//
// So only those primitives can shade P whose box, projected down along the same direction, covers
// G. The grid holds these footprints in square cells: a query reads one cell.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace egosieve::vision {

class ShadowGrid {
 public:
  ShadowGrid() = default;
  // Footprints of `bounds` outside `area` are dropped: points there are not shaded.
  ShadowGrid(const std::vector<Eigen::AlignedBox3d>& bounds, const Eigen::Vector3d& to_sun,
             const Eigen::AlignedBox2d& area, double cell_metres);

  struct Range {
    const int32_t* begin = nullptr;
    const int32_t* end = nullptr;
  };
  // Indices into `bounds` of the primitives that may shade the point.
  Range Candidates(const Eigen::Vector3d& point) const;

 private:
  Eigen::Vector3d to_sun_ = Eigen::Vector3d::UnitZ();
  Eigen::AlignedBox2d area_;
  double cell_ = 1.0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<int32_t> starts_;
  std::vector<int32_t> indices_;
};

}  // namespace egosieve::vision
