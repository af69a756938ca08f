#include "vision/paper/neighbour_agreement.h"

#include <cmath>
#include <unordered_map>

namespace egosieve::vision {
namespace {

constexpr double kFurthest = 1e6;  // pixels; larger coordinates are not in any image

bool IsUsable(const PointPair& p) {
  for (const double value : {p.x1, p.y1, p.x2, p.y2}) {
    if (!(std::abs(value) < kFurthest)) return false;
  }
  return true;
}

// Cells of an unbounded plane: pairs may lie outside of the picture.
int64_t CellOf(double x, double y, double side, int dx, int dy) {
  const auto column = static_cast<int64_t>(std::floor(x / side)) + dx;
  const auto row = static_cast<int64_t>(std::floor(y / side)) + dy;
  return (row << 32) ^ (column & 0xffffffff);
}

}  // namespace

std::vector<uint8_t> AgreesWithNeighbours(const std::vector<PointPair>& pairs,
                                          const NeighbourAgreementOptions& options) {
  const double radius = options.radius_pixels;
  std::unordered_map<int64_t, std::vector<size_t>> cells;
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (IsUsable(pairs[i])) cells[CellOf(pairs[i].x1, pairs[i].y1, radius, 0, 0)].push_back(i);
  }
  std::vector<uint8_t> agrees(pairs.size(), 0);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const PointPair& p = pairs[i];
    if (!IsUsable(p)) continue;
    const double dx = p.x2 - p.x1, dy = p.y2 - p.y1;
    const double tolerance =
        options.tolerance_pixels + options.tolerance_slope * std::hypot(dx, dy);
    int neighbours = 0;
    for (int cell = 0; cell < 9 && neighbours < options.minimum_neighbours; ++cell) {
      const auto found = cells.find(CellOf(p.x1, p.y1, radius, cell % 3 - 1, cell / 3 - 1));
      if (found == cells.end()) continue;
      for (const size_t j : found->second) {
        const PointPair& q = pairs[j];
        neighbours += j != i && std::hypot(q.x1 - p.x1, q.y1 - p.y1) <= radius &&
                      std::hypot(q.x2 - q.x1 - dx, q.y2 - q.y1 - dy) <= tolerance;
      }
    }
    agrees[i] = neighbours >= options.minimum_neighbours ? 1 : 0;
  }
  return agrees;
}

}  // namespace egosieve::vision
