// Lists the primitives that each square tile of the image can see, nearest first.
//
// Rays are o + t d with unit component of d along the optical axis, so that t is the depth Z. A
// primitive is listed in the tiles that the projection of its bounding box touches (grown by a
// pixel), with the smallest depth of the box. Once a hit is nearer than the next entry's depth, the
// rest of the list can be skipped.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "vision/image/cell_grid.h"
#include "vision/synthetic/camera.h"

namespace egosieve::vision {

class TileVisibility {
 public:
  static constexpr int kTile = 16;  // pixels

  struct Entry {
    float depth = 0.0f;
    int32_t primitive = 0;
  };

  // Indices count through `scenery`, then through `movable`.
  TileVisibility(const std::vector<Eigen::AlignedBox3d>& scenery,
                 const std::vector<Eigen::AlignedBox3d>& movable, const Intrinsics& intrinsics,
                 const Pose& pose, int width, int height, double far_metres);

  int columns() const { return tiles_.columns; }
  int rows() const { return tiles_.rows; }
  const Entry* begin(int tile) const { return entries_.data() + starts_[tile]; }
  const Entry* end(int tile) const { return entries_.data() + starts_[tile + 1]; }

 private:
  SquareCells<int> tiles_;
  std::vector<int32_t> starts_;
  std::vector<Entry> entries_;
};

}  // namespace egosieve::vision
