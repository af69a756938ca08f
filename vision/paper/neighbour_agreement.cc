#include "vision/paper/neighbour_agreement.h"

#include <cmath>

namespace egosieve::vision {
namespace {

constexpr double kRadius = 40.0;    // pixels
constexpr double kTolerance = 3.0;  // pixels
constexpr double kToleranceSlope = 0.15;
constexpr int kFewestNeighbours = 2;

bool Within(double x, double y, double radius) { return x * x + y * y <= radius * radius; }

}  // namespace

std::vector<uint8_t> AgreesWithNeighbours(const std::vector<PointPair>& pairs) {
  std::vector<uint8_t> agrees(pairs.size(), 0);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const PointPair& p = pairs[i];
    const double dx = p.x2 - p.x1, dy = p.y2 - p.y1;
    const double tolerance = kTolerance + kToleranceSlope * std::hypot(dx, dy);
    int neighbours = 0;
    for (size_t j = 0; j < pairs.size() && neighbours < kFewestNeighbours; ++j) {
      const PointPair& q = pairs[j];
      neighbours += j != i && Within(q.x1 - p.x1, q.y1 - p.y1, kRadius) &&
                    Within(q.x2 - q.x1 - dx, q.y2 - q.y1 - dy, tolerance);
    }
    agrees[i] = neighbours == kFewestNeighbours ? 1 : 0;
  }
  return agrees;
}

}  // namespace egosieve::vision
