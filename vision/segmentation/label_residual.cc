#include "vision/segmentation/label_residual.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <nanoflann.hpp>
#include <opencv2/imgproc.hpp>

#include "vision/segmentation/rows.h"

namespace egosieve::vision {
namespace {

constexpr int kStridePixels = 5;
constexpr double kLeast = 0.01;         // in (LR1)
constexpr double kStepsPerUnit = 12.0;  // the largest residual, 2 logit(0.99), is 110 steps
constexpr float kLeastProbability = 1e-6f;

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointCloud>,
                                                 PointCloud, 2, size_t>;

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

double Logit(double p) {
  p = std::clamp(p, kLeast, 1.0 - kLeast);
  return std::log(p / (1.0 - p));
}

// The cell of the grid nearest to a pixel.
int CellOf(int pixel, int cells) {
  return std::min((pixel + kStridePixels / 2) / kStridePixels, cells - 1);
}

}  // namespace

std::vector<float> SpreadToGrid(kernels::ConstMatrixView<double> positions,
                                const std::vector<double>& values, const ImageGrid& grid) {
  std::vector<float> spread(grid.size(), 0.0f);
  if (positions.rows == 0) return spread;
  const PointCloud places{positions};
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

LabelResidual::LabelResidual(int64_t frame_index, cv::Size size,
                             kernels::ConstMatrixView<double> positions,
                             absl::Span<const double> labels, absl::Span<const float> own) {
  if (positions.rows == 0) return;
  frame_index_ = frame_index;
  grid_ = ImageGrid{size.width, size.height, kStridePixels};
  std::vector<double> residuals;
  residuals.reserve(labels.size());
  for (size_t i = 0; i < labels.size(); ++i) {
    residuals.push_back(Logit(labels[i]) - Logit(own[i]));
  }
  std::vector<float> spread = SpreadToGrid(positions, residuals, grid_);
  cv::Mat1f smoothed(grid_.rows(), grid_.columns());
  cv::medianBlur(cv::Mat1f(grid_.rows(), grid_.columns(), spread.data()), smoothed, 3);
  for (const float residual : smoothed) {
    steps_.push_back(static_cast<int8_t>(std::lround(kStepsPerUnit * residual)));
  }
}

void LabelResidual::Apply(double weight, SegmentationMap& map) const {
  const ImageGrid& grid = map.grid;
  if (steps_.empty() || map.frame_index != frame_index_ || grid.width != grid_.width ||
      grid.height != grid_.height) {
    return;
  }
  std::array<float, 256> factors;  // of the odds, by step
  for (int step = -128; step < 128; ++step) {
    factors[step + 128] = static_cast<float>(std::exp(weight * step / kStepsPerUnit));
  }
  const int columns = grid_.columns();
  for (int row = 0; row < grid.rows(); ++row) {
    const int8_t* steps = &steps_[CellOf(grid.y_pixels(row), grid_.rows()) * columns];
    for (int column = 0; column < grid.columns(); ++column) {
      const float factor = factors[steps[CellOf(grid.x_pixels(column), columns)] + 128];
      float& p = map.probability[static_cast<size_t>(row) * grid.columns() + column];
      const float q = std::clamp(p, kLeastProbability, 1.0f - kLeastProbability);
      p = q * factor / (1.0f - q + q * factor);
    }
  }
}

}  // namespace egosieve::vision
