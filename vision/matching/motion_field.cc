#include "vision/matching/motion_field.h"

#include <algorithm>
#include <cmath>

#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr size_t kFewestMatches = 3;

struct CellMatches {
  std::vector<float> x, y;  // components of velocities
};

// The mean of the known cells around (row, column); false where there is none.
bool MeanAround(const MotionField& field, const std::vector<uint8_t>& known, int row, int column,
                cv::Point2f& mean) {
  cv::Point2f sum(0.0F, 0.0F);
  int count = 0;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, field.rows - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, field.columns - 1); ++c) {
      const size_t cell = static_cast<size_t>(r) * field.columns + c;
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
        const size_t cell = static_cast<size_t>(row) * field.columns + column;
        if (known[cell] != 0) continue;
        if (!MeanAround(field, before, row, column, field.velocities[cell])) continue;
        known[cell] = 1;
        grows = true;
      }
    }
  }
}

int CellOf(double place, int count) {
  return std::clamp(static_cast<int>(place / MotionField::kCellPixels), 0, count - 1);
}

cv::Point2f VelocityAt(const MotionField& field, cv::Point2f at) {
  const auto cell = [](float place, int count) {
    const float centre = place / MotionField::kCellPixels - 0.5F;
    return std::clamp(centre, 0.0F, static_cast<float>(count - 1));
  };
  const float x = cell(at.x, field.columns), y = cell(at.y, field.rows);
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const int right = std::min(left + 1, field.columns - 1);
  const int bottom = std::min(top + 1, field.rows - 1);
  const float fx = x - static_cast<float>(left), fy = y - static_cast<float>(top);
  const auto velocity = [&](int row, int column) {
    return field.velocities[static_cast<size_t>(row) * field.columns + column];
  };
  return (1 - fy) * ((1 - fx) * velocity(top, left) + fx * velocity(top, right)) +
         fy * ((1 - fx) * velocity(bottom, left) + fx * velocity(bottom, right));
}

}  // namespace

MotionField MakeMotionField(const std::vector<PointPair>& pairs, int gap, cv::Size size) {
  constexpr int kCell = MotionField::kCellPixels;
  MotionField field;
  field.columns = (size.width + kCell - 1) / kCell;
  field.rows = (size.height + kCell - 1) / kCell;
  std::vector<CellMatches> cells(static_cast<size_t>(field.columns) * field.rows);
  for (const PointPair& pair : pairs) {
    const double dx = (pair.x2 - pair.x1) / gap, dy = (pair.y2 - pair.y1) / gap;
    if (!std::isfinite(pair.x1 + dx) || !std::isfinite(pair.y1 + dy)) continue;
    const int column = CellOf(std::clamp(pair.x1 + dx, 0.0, size.width - 1.0), field.columns);
    const int row = CellOf(std::clamp(pair.y1 + dy, 0.0, size.height - 1.0), field.rows);
    CellMatches& cell = cells[static_cast<size_t>(row) * field.columns + column];
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
