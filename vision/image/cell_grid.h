// Rows and columns of cells over a picture, numbered row by row.
//
// A position belongs to the cell that contains it; one beyond the outermost cells belongs to the
// nearest of these, and one that is NaN to the first row or column.
#pragma once

#include <algorithm>
#include <cstddef>
#include <opencv2/core.hpp>

namespace egosieve::vision {

// at: in cells from the first cell's edge. count: positive.
template <typename Real>
int CellAlong(Real at, int count) {
  return static_cast<int>(std::max(Real{0}, std::min(at, static_cast<Real>(count - 1))));
}

struct CellGrid {
  int columns = 0, rows = 0;

  size_t size() const { return Index(rows, 0); }
  size_t Index(int row, int column) const { return static_cast<size_t>(row) * columns + column; }
  // x, y: in cells.
  template <typename Real>
  size_t IndexAt(Real x, Real y) const {
    return Index(CellAlong(y, rows), CellAlong(x, columns));
  }
};

// Square cells; positions are in pixels. With whole positions and a whole side, division truncates.
template <typename Side>
struct SquareCells : CellGrid {
  Side side{};

  template <typename Length>
  int ColumnOf(Length x) const {
    return CellAlong(x / side, columns);
  }
  template <typename Length>
  int RowOf(Length y) const {
    return CellAlong(y / side, rows);
  }
  template <typename Length>
  size_t IndexOf(Length x, Length y) const {
    return Index(RowOf(y), ColumnOf(x));
  }
};

// The cells that contain a pixel of the picture.
inline SquareCells<int> CellsOfPixels(cv::Size picture, int side) {
  return {{(picture.width + side - 1) / side, (picture.height + side - 1) / side}, side};
}

// The cells that contain the positions from (0, 0) to (x, y); both are included and not negative.
template <typename Side, typename Length>
SquareCells<Side> CellsUpTo(Length x, Length y, Side side) {
  return {{static_cast<int>(x / side) + 1, static_cast<int>(y / side) + 1}, side};
}

}  // namespace egosieve::vision
