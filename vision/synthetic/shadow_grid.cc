#include "vision/synthetic/shadow_grid.h"

#include <algorithm>
#include <cmath>

namespace egosieve::vision {
namespace {

Eigen::Vector2d GroundPoint(const Eigen::Vector3d& point, const Eigen::Vector3d& to_sun) {
  return point.head<2>() - to_sun.head<2>() * (point.z() / to_sun.z());  // (SG1)
}

}  // namespace

ShadowGrid::ShadowGrid(const std::vector<Eigen::AlignedBox3d>& bounds,
                       const Eigen::Vector3d& to_sun, const Eigen::AlignedBox2d& area,
                       double cell_metres)
    : to_sun_(to_sun), area_(area), cell_(cell_metres) {
  const Eigen::Vector2d size = area.sizes();
  columns_ = static_cast<int>(std::ceil(size.x() / cell_));
  rows_ = static_cast<int>(std::ceil(size.y() / cell_));
  struct Cells {
    int x0, x1, y0, y1;
  };
  std::vector<Cells> cells;
  cells.reserve(bounds.size());
  starts_.assign(static_cast<size_t>(columns_) * rows_ + 1, 0);
  for (const Eigen::AlignedBox3d& box : bounds) {
    Eigen::AlignedBox2d footprint;
    for (int corner = 0; corner < 8; ++corner) {
      const auto type = static_cast<Eigen::AlignedBox3d::CornerType>(corner);
      footprint.extend(GroundPoint(box.corner(type), to_sun));
    }
    const Eigen::Vector2d low = (footprint.min() - area.min()) / cell_;
    const Eigen::Vector2d high = (footprint.max() - area.min()) / cell_;
    const Cells c{std::max(0, static_cast<int>(std::floor(low.x()))),
                  std::min(columns_ - 1, static_cast<int>(std::floor(high.x()))),
                  std::max(0, static_cast<int>(std::floor(low.y()))),
                  std::min(rows_ - 1, static_cast<int>(std::floor(high.y())))};
    cells.push_back(c);
    for (int y = c.y0; y <= c.y1; ++y) {
      for (int x = c.x0; x <= c.x1; ++x) ++starts_[static_cast<size_t>(y) * columns_ + x + 1];
    }
  }
  for (size_t k = 1; k < starts_.size(); ++k) starts_[k] += starts_[k - 1];
  indices_.resize(starts_.back());
  std::vector<int32_t> next(starts_.begin(), starts_.end() - 1);
  for (size_t k = 0; k < cells.size(); ++k) {
    const Cells& c = cells[k];
    for (int y = c.y0; y <= c.y1; ++y) {
      for (int x = c.x0; x <= c.x1; ++x) {
        indices_[next[static_cast<size_t>(y) * columns_ + x]++] = static_cast<int32_t>(k);
      }
    }
  }
}

ShadowGrid::Range ShadowGrid::Candidates(const Eigen::Vector3d& point) const {
  const Eigen::Vector2d q = (GroundPoint(point, to_sun_) - area_.min()) / cell_;
  if (!(q.x() >= 0.0 && q.y() >= 0.0 && q.x() < columns_ && q.y() < rows_)) return {};
  const size_t cell = static_cast<size_t>(q.y()) * columns_ + static_cast<size_t>(q.x());
  return {indices_.data() + starts_[cell], indices_.data() + starts_[cell + 1]};
}

}  // namespace egosieve::vision
