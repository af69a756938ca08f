#include "vision/matching/motion_field.h"

#include <algorithm>
#include <cmath>

#include "vision/image/bilinear.h"
#include "vision/image/cell_grid.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr size_t kFewestMatches = 3;

struct CellMatches {
  std::vector<float> x, y;  // components of velocities
};

CellGrid CellsOf(const MotionField& field) { return {field.columns, field.rows}; }

// The mean of the known cells around (row, column); false where there is none.
bool MeanAround(const MotionField& field, const std::vector<uint8_t>& known, int row, int column,
                cv::Point2f& mean) {
  cv::Point2f sum(0.0F, 0.0F);
  int count = 0;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, field.rows - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, field.columns - 1); ++c) {
      const size_t cell = CellsOf(field).Index(r, c);
      if (known[cell] == 0) continue;
      sum += field.velocities[cell];
      ++count;
    }
  }
  if (count == 0) return false;
  mean = sum / static_cast<float>(count);
  return true;
}

void FillRings(MotionField& field, std::vector<uint8_t>& known) {
  for (bool grows = true; grows;) {
    grows = false;
    const std::vector<uint8_t> before = known;
    for (int row = 0; row < field.rows; ++row) {
      for (int column = 0; column < field.columns; ++column) {
        const size_t cell = CellsOf(field).Index(row, column);
        if (known[cell] != 0) continue;
        if (!MeanAround(field, before, row, column, field.velocities[cell])) continue;
        known[cell] = 1;
        grows = true;
      }
    }
  }
}

cv::Point2f VelocityAt(const MotionField& field, cv::Point2f at) {
  const auto among = [](float place, int count) {  // the cells' centres
    return AroundClamped<AtLast::kAlone>(place / MotionField::kCellPixels - 0.5F, count);
  };
  return BilinearByWeights(
      among(at.x, field.columns), among(at.y, field.rows),
      [&](int row, int column) { return field.velocities[CellsOf(field).Index(row, column)]; });
}

}  // namespace

MotionField MakeMotionField(const std::vector<PointPair>& pairs, int gap, cv::Size size) {
  const SquareCells<int> grid = CellsOfPixels(size, MotionField::kCellPixels);
  MotionField field;
  field.columns = grid.columns;
  field.rows = grid.rows;
  std::vector<CellMatches> cells(grid.size());
  for (const PointPair& pair : pairs) {
    const double dx = (pair.x2 - pair.x1) / gap, dy = (pair.y2 - pair.y1) / gap;
    if (!std::isfinite(pair.x1 + dx) || !std::isfinite(pair.y1 + dy)) continue;
    CellMatches& cell = cells[grid.IndexOf(pair.x1 + dx, pair.y1 + dy)];
    cell.x.push_back(static_cast<float>(dx));
    cell.y.push_back(static_cast<float>(dy));
  }
  field.velocities.resize(cells.size());
  std::vector<uint8_t> known(cells.size(), 0);
  for (size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].x.size() < kFewestMatches) continue;
    field.velocities[i] = {MedianInPlace(cells[i].x), MedianInPlace(cells[i].y)};
    known[i] = 1;
  }
  if (std::find(known.begin(), known.end(), 1) == known.end()) return MotionField();
  FillRings(field, known);
  return field;
}

std::vector<cv::Point2f> PredictPlaces(const MotionField& field,
                                       const std::vector<cv::Point2f>& places, int pictures) {
  std::vector<cv::Point2f> predicted;
  predicted.reserve(places.size());
  for (const cv::Point2f& place : places) {
    predicted.push_back(place + static_cast<float>(pictures) * VelocityAt(field, place));
  }
  return predicted;
}

}  // namespace egosieve::vision
