#include "vision/segmentation/nearest_feature.h"

#include <cstddef>
#include <nanoflann.hpp>

namespace egosieve::vision {
namespace {

struct Places {
  kernels::ConstMatrixView<double> positions;

  size_t kdtree_get_point_count() const { return static_cast<size_t>(positions.rows); }
  double kdtree_get_pt(size_t index, size_t axis) const {
    return positions.row(static_cast<int64_t>(index))[axis];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Places>,
                                                 Places, 2, size_t>;

// The nearest feature; of equally near ones the first in the list, for any order of the tree.
class FirstNearest {
 public:
  using DistanceType = double;
  bool full() const { return found_; }
  size_t size() const { return found_ ? 1 : 0; }
  double worstDist() const { return distance_; }
  bool addPoint(double distance, size_t index) {
    if (distance < distance_ || (distance == distance_ && index < index_)) {
      distance_ = distance;
      index_ = index;
      found_ = true;
    }
    return true;
  }
  void sort() {}
  size_t index() const { return index_; }

 private:
  bool found_ = false;
  double distance_ = std::numeric_limits<double>::max();
  size_t index_ = std::numeric_limits<size_t>::max();
};

}  // namespace

std::vector<float> SpreadToGrid(kernels::ConstMatrixView<double> positions,
                                const std::vector<double>& values, const ImageGrid& grid,
                                double otherwise) {
  std::vector<float> spread(grid.size(), static_cast<float>(otherwise));
  if (positions.rows == 0) return spread;
  const Places places{positions};
  const Tree tree(2, places, nanoflann::KDTreeSingleIndexAdaptorParams());
  size_t next = 0;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const double query[] = {static_cast<double>(grid.x_pixels(column)),
                              static_cast<double>(grid.y_pixels(row))};
      FirstNearest nearest;
      tree.findNeighbors(nearest, query, {});
      spread[next++] = static_cast<float>(values[nearest.index()]);
    }
  }
  return spread;
}

}  // namespace egosieve::vision
