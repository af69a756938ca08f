// Segments the points of an image into surfaces of one depth.
//
// Points lie in the cells of a raster, and one point represents each cell. Points of neighbouring
// cells are joined if they are alike, the most alike first, and if the means of the surfaces to
// which they belong are alike, too:
//
//   |r_a - r_b| < 2 sigma + 0.1 max(|r_a|, |r_b|),   r, sigma: means over the surface          (U1)
//
// The second condition is needed because flow is smooth: by neighbours alone a car would be joined
// to the house behind it. Reference: Felzenszwalb & Huttenlocher (2004), the order of joining.
// Cost: n log n.
#pragma once

#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "vision/evidence/road_plane.h"
#include "vision/image/cell_grid.h"

namespace egosieve::vision {

// Square cells, about one per place.
class Raster {
 public:
  Raster(const std::vector<cv::Point2f>& places, cv::Size image);

  int rows() const { return cells_.rows; }
  int columns() const { return cells_.columns; }
  // The index of the place that represents a cell; -1: none.
  int At(int row, int column) const { return representatives_[cells_.Index(row, column)]; }
  // Row and column.
  std::pair<int, int> CellAt(cv::Point2f place) const {
    return {cells_.RowOf(place.y), cells_.ColumnOf(place.x)};
  }
  int RepresentativeOf(cv::Point2f place) const {
    return representatives_[cells_.IndexOf(place.x, place.y)];
  }

 private:
  SquareCells<double> cells_;
  std::vector<int> representatives_;
};

// The surface of each point; -1 for points without `is_part` and points that represent no cell.
// Surfaces are numbered from 0.
std::vector<int> FindSurfaces(const Raster& raster, const std::vector<InverseDepth>& points,
                              const std::vector<bool>& is_part);

}  // namespace egosieve::vision
