#include "vision/synthetic/visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace egosieve::vision {
namespace {

constexpr double kNear = 0.05;  // metres; no object is nearer
constexpr double kFarMetres = 320.0;
constexpr double kViewCellPixels = 16.0;
constexpr double kShadowCellMetres = 3.0;

// The image of a box, clipped at the near plane. False if the box is behind, beyond or beside the
// view.
bool ProjectBox(const Eigen::AlignedBox3d& box, const Intrinsics& intrinsics, const Pose& pose,
                Eigen::AlignedBox2d* image, double* depth) {
  Eigen::Vector3d corners[8];
  double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
  for (int k = 0; k < 8; ++k) {
    const auto type = static_cast<Eigen::AlignedBox3d::CornerType>(k);
    corners[k] = pose.rotation.transpose() * (box.corner(type) - pose.centre);
    nearest = std::min(nearest, corners[k].z());
    farthest = std::max(farthest, corners[k].z());
  }
  if (!(farthest > kNear) || nearest > kFarMetres) return false;
  *depth = std::max(nearest, 0.0);
  image->setEmpty();
  for (int k = 0; k < 8; ++k) {
    if (corners[k].z() >= kNear) image->extend(intrinsics.Project(corners[k]));
    for (const int bit : {1, 2, 4}) {  // the box's edges that cross the near plane
      const int other = k ^ bit;
      if (other < k || (corners[k].z() < kNear) == (corners[other].z() < kNear)) continue;
      const double t = (kNear - corners[k].z()) / (corners[other].z() - corners[k].z());
      Eigen::Vector3d crossing = corners[k] + t * (corners[other] - corners[k]);
      crossing.z() = kNear;
      image->extend(intrinsics.Project(crossing));
    }
  }
  return true;
}

}  // namespace

CandidateLists::CandidateLists(const Eigen::AlignedBox2d& area, double cell)
    : area_(area),
      cell_(cell),
      columns_(static_cast<int>(std::ceil(area.sizes().x() / cell))),
      rows_(static_cast<int>(std::ceil(area.sizes().y() / cell))),
      lists_(static_cast<size_t>(columns_) * rows_) {}

void CandidateLists::Add(const Eigen::AlignedBox2d& footprint, const Candidate& candidate) {
  const Eigen::Vector2d low = (footprint.min() - area_.min()) / cell_;
  const Eigen::Vector2d high = (footprint.max() - area_.min()) / cell_;
  const int x1 = std::min(columns_ - 1, static_cast<int>(std::floor(high.x())));
  const int y1 = std::min(rows_ - 1, static_cast<int>(std::floor(high.y())));
  for (int y = std::max(0, static_cast<int>(std::floor(low.y()))); y <= y1; ++y) {
    for (int x = std::max(0, static_cast<int>(std::floor(low.x()))); x <= x1; ++x) {
      lists_[static_cast<size_t>(y) * columns_ + x].push_back(candidate);
    }
  }
}

const std::vector<Candidate>& CandidateLists::At(const Eigen::Vector2d& place) const {
  const Eigen::Vector2d q = (place - area_.min()) / cell_;
  if (!(q.x() >= 0.0 && q.y() >= 0.0 && q.x() < columns_ && q.y() < rows_)) return none_;
  return lists_[static_cast<size_t>(q.y()) * columns_ + static_cast<size_t>(q.x())];
}

CandidateLists ListView(const std::vector<Eigen::AlignedBox3d>& bounds, const PinholeView& view,
                        const Pose& pose) {
  std::vector<std::pair<Candidate, Eigen::AlignedBox2d>> seen;
  for (size_t k = 0; k < bounds.size(); ++k) {
    Eigen::AlignedBox2d image;
    double depth;
    if (!ProjectBox(bounds[k], view.intrinsics, pose, &image, &depth)) continue;
    seen.push_back({{static_cast<int32_t>(k), static_cast<float>(depth) * 0.99999f}, image});
  }
  std::stable_sort(seen.begin(), seen.end(),
                   [](const auto& a, const auto& b) { return a.first.depth < b.first.depth; });
  CandidateLists lists({Eigen::Vector2d::Zero(), Eigen::Vector2d(view.width, view.height)},
                       kViewCellPixels);
  for (auto& [candidate, image] : seen) {
    // One pixel of margin for the rays between pixels, which smooth edges.
    image.min().array() -= 1.0;
    image.max().array() += 1.0;
    lists.Add(image, candidate);
  }
  return lists;
}

Eigen::Vector2d ShadowPlace(const Eigen::Vector3d& point, const Eigen::Vector3d& to_sun) {
  return point.head<2>() - to_sun.head<2>() * (point.z() / to_sun.z());
}

CandidateLists ListShadows(const std::vector<Eigen::AlignedBox3d>& bounds, size_t first,
                           const Eigen::Vector3d& to_sun, const Eigen::AlignedBox2d& area) {
  CandidateLists lists(area, kShadowCellMetres);
  for (size_t k = first; k < bounds.size(); ++k) {
    Eigen::AlignedBox2d footprint;
    for (int corner = 0; corner < 8; ++corner) {
      const auto type = static_cast<Eigen::AlignedBox3d::CornerType>(corner);
      footprint.extend(ShadowPlace(bounds[k].corner(type), to_sun));
    }
    lists.Add(footprint, {static_cast<int32_t>(k)});
  }
  return lists;
}

}  // namespace egosieve::vision
