#include "vision/synthetic/visibility.h"

#include <algorithm>
#include <limits>

namespace egosieve::vision {
namespace {

constexpr double kNear = 0.05;  // metres; no object is nearer

struct Footprint {
  int x0, x1, y0, y1;  // tiles
  float depth;
  int32_t primitive;
};

// The image of a box, clipped at the near plane. False if the box is behind, beyond or beside the
// view.
bool ProjectBox(const Eigen::AlignedBox3d& box, const Intrinsics& intrinsics, const Pose& pose,
                double far_metres, Eigen::AlignedBox2d* image, double* depth) {
  Eigen::Vector3d corners[8];
  double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
  for (int k = 0; k < 8; ++k) {
    const auto type = static_cast<Eigen::AlignedBox3d::CornerType>(k);
    corners[k] = pose.rotation.transpose() * (box.corner(type) - pose.centre);
    nearest = std::min(nearest, corners[k].z());
    farthest = std::max(farthest, corners[k].z());
  }
  if (!(farthest > kNear) || nearest > far_metres) return false;
  *depth = std::max(nearest, 0.0);
  image->setEmpty();
  const auto extend = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector2d ray(p.x() / p.z(), p.y() / p.z());
    image->extend(intrinsics.focal_pixels * ray +
                  Eigen::Vector2d(intrinsics.centre_x, intrinsics.centre_y));
  };
  for (int k = 0; k < 8; ++k) {
    if (corners[k].z() >= kNear) extend(corners[k]);
    for (const int bit : {1, 2, 4}) {  // the box's edges that cross the near plane
      const int other = k ^ bit;
      if (other < k || (corners[k].z() < kNear) == (corners[other].z() < kNear)) continue;
      const double t = (kNear - corners[k].z()) / (corners[other].z() - corners[k].z());
      Eigen::Vector3d crossing = corners[k] + t * (corners[other] - corners[k]);
      crossing.z() = kNear;
      extend(crossing);
    }
  }
  return true;
}

}  // namespace

TileVisibility::TileVisibility(const std::vector<Eigen::AlignedBox3d>& scenery,
                               const std::vector<Eigen::AlignedBox3d>& movable,
                               const Intrinsics& intrinsics, const Pose& pose, int width,
                               int height, double far_metres)
    : tiles_(CellsOfPixels({width, height}, kTile)) {
  std::vector<Footprint> footprints;
  starts_.assign(tiles_.size() + 1, 0);
  const size_t count = scenery.size() + movable.size();
  for (size_t k = 0; k < count; ++k) {
    const Eigen::AlignedBox3d& box = k < scenery.size() ? scenery[k] : movable[k - scenery.size()];
    Eigen::AlignedBox2d image;
    double depth;
    if (!ProjectBox(box, intrinsics, pose, far_metres, &image, &depth)) continue;
    // One pixel of margin for the rays between pixels, which smooth edges.
    const double x0 = image.min().x() - 1.0, x1 = image.max().x() + 1.0;
    const double y0 = image.min().y() - 1.0, y1 = image.max().y() + 1.0;
    if (x1 < 0.0 || y1 < 0.0 || x0 > width - 1 || y0 > height - 1) continue;
    const Footprint f{tiles_.ColumnOf(x0),
                      tiles_.ColumnOf(x1),
                      tiles_.RowOf(y0),
                      tiles_.RowOf(y1),
                      static_cast<float>(depth) * 0.99999f,
                      static_cast<int32_t>(k)};
    footprints.push_back(f);
    for (int y = f.y0; y <= f.y1; ++y) {
      for (int x = f.x0; x <= f.x1; ++x) ++starts_[tiles_.Index(y, x) + 1];
    }
  }
  for (size_t k = 1; k < starts_.size(); ++k) starts_[k] += starts_[k - 1];
  entries_.resize(starts_.back());
  std::sort(footprints.begin(), footprints.end(), [](const Footprint& a, const Footprint& b) {
    return a.depth != b.depth ? a.depth < b.depth : a.primitive < b.primitive;
  });
  std::vector<int32_t> next(starts_.begin(), starts_.end() - 1);
  for (const Footprint& f : footprints) {
    for (int y = f.y0; y <= f.y1; ++y) {
      for (int x = f.x0; x <= f.x1; ++x) {
        entries_[next[tiles_.Index(y, x)]++] = {f.depth, f.primitive};
      }
    }
  }
}

}  // namespace egosieve::vision
