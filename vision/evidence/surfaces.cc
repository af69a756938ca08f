#include "vision/evidence/surfaces.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace egosieve::vision {
namespace {

constexpr double kLeastCellPixels = 4.0;
// Greatest differences between neighbours and between surfaces, in deviations and as a share of r.
constexpr double kNeighbourDeviations = 1.5, kNeighbourShare = 0.05;
constexpr double kSurfaceDeviations = 2.0, kSurfaceShare = 0.1;

struct Edge {
  double apart;
  int first, second;
};

bool AreNeighboursAlike(const InverseDepth& a, const InverseDepth& b) {
  return std::abs(a.value - b.value) <
         kNeighbourDeviations * std::hypot(a.deviation, b.deviation) +
             kNeighbourShare * std::max(std::abs(a.value), std::abs(b.value));
}

std::vector<Edge> EdgesOf(const Raster& raster, const std::vector<InverseDepth>& points,
                          const std::vector<bool>& is_part) {
  std::vector<Edge> edges;
  for (int row = 0; row < raster.rows(); ++row) {
    for (int column = 0; column < raster.columns(); ++column) {
      const int i = raster.At(row, column);
      if (i < 0 || !is_part[i]) continue;
      const int right = column + 1 < raster.columns() ? raster.At(row, column + 1) : -1;
      const int below = row + 1 < raster.rows() ? raster.At(row + 1, column) : -1;
      for (const int k : {right, below}) {
        if (k >= 0 && is_part[k] && AreNeighboursAlike(points[i], points[k])) {
          edges.push_back({std::abs(points[i].value - points[k].value), i, k});
        }
      }
    }
  }
  // Ties stay in the order of the raster, so that the surfaces do not depend on the sort.
  std::stable_sort(edges.begin(), edges.end(),
                   [](const Edge& a, const Edge& b) { return a.apart < b.apart; });
  return edges;
}

// Points joined into surfaces, with sums over the points of each surface.
class Joined {
 public:
  explicit Joined(const std::vector<InverseDepth>& points) : parents_(points.size()) {
    std::iota(parents_.begin(), parents_.end(), 0);
    for (const InverseDepth& point : points) sums_.push_back({point.value, point.deviation, 1.0});
  }

  int Find(int i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }
  void JoinIfAlike(int i, int k) {
    const int a = Find(i), b = Find(k);
    if (a == b || !AreAlike(sums_[a], sums_[b])) return;
    const int kept = std::min(a, b), other = std::max(a, b);
    parents_[other] = kept;
    sums_[kept].value += sums_[other].value;
    sums_[kept].deviation += sums_[other].deviation;
    sums_[kept].count += sums_[other].count;
  }

 private:
  struct Sums {
    double value, deviation, count;
  };

  static bool AreAlike(const Sums& a, const Sums& b) {
    const double first = a.value / a.count, second = b.value / b.count;
    const double deviation = (a.deviation + b.deviation) / (a.count + b.count);
    return std::abs(first - second) <
           kSurfaceDeviations * deviation +
               kSurfaceShare * std::max(std::abs(first), std::abs(second));
  }

  std::vector<int> parents_;
  std::vector<Sums> sums_;
};

double CellPixels(size_t places, cv::Size image) {
  const auto count = static_cast<double>(std::max<size_t>(places, 1));
  return std::max(kLeastCellPixels, std::sqrt(static_cast<double>(image.area()) / count));
}

}  // namespace

Raster::Raster(const std::vector<cv::Point2f>& places, cv::Size image)
    : cells_(CellsUpTo(image.width, image.height, CellPixels(places.size(), image))),
      representatives_(cells_.size(), -1) {
  for (size_t i = 0; i < places.size(); ++i) {
    int& representative = representatives_[cells_.IndexOf(places[i].x, places[i].y)];
    if (representative < 0) representative = static_cast<int>(i);
  }
}

std::vector<int> FindSurfaces(const Raster& raster, const std::vector<InverseDepth>& points,
                              const std::vector<bool>& is_part) {
  Joined joined(points);
  for (const Edge& edge : EdgesOf(raster, points, is_part)) {
    joined.JoinIfAlike(edge.first, edge.second);
  }
  std::vector<int> surfaces(points.size(), -1), number_of_root(points.size(), -1);
  int count = 0;
  for (int row = 0; row < raster.rows(); ++row) {
    for (int column = 0; column < raster.columns(); ++column) {
      const int i = raster.At(row, column);
      if (i < 0 || !is_part[i]) continue;
      int& number = number_of_root[joined.Find(i)];
      if (number < 0) number = count++;
      surfaces[i] = number;
    }
  }
  return surfaces;
}

}  // namespace egosieve::vision
