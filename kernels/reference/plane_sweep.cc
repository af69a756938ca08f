#include "kernels/reference/plane_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace egosieve::kernels::reference {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double LevelAt(const ImageView& picture, double x, double y) {
  const int column = std::min(static_cast<int>(x), picture.width - 2);
  const int row = std::min(static_cast<int>(y), picture.height - 2);
  const double fx = x - column, fy = y - row;
  const uint8_t* upper = picture.data + row * picture.stride_bytes + column;
  const uint8_t* lower = upper + picture.stride_bytes;
  return (1 - fy) * ((1 - fx) * upper[0] + fx * upper[1]) +
         fy * ((1 - fx) * lower[0] + fx * lower[1]);
}

// The patch less its mean, row by row; empty if it leaves the picture.
std::vector<double> PatchAt(const ImageView& picture, double x, double y, double scale,
                            int radius) {
  const double reach = scale * radius;
  if (!(x - reach >= 0 && y - reach >= 0 && x + reach < picture.width - 1 &&
        y + reach < picture.height - 1)) {
    return {};
  }
  std::vector<double> patch;
  double sum = 0.0;
  for (int v = -radius; v <= radius; ++v) {
    for (int u = -radius; u <= radius; ++u) {
      patch.push_back(LevelAt(picture, x + scale * u, y + scale * v));
      sum += patch.back();
    }
  }
  for (double& level : patch) level -= sum / static_cast<double>(patch.size());
  return patch;
}

// NaN if `b` is empty.
double SquaredDifference(const std::vector<double>& a, const std::vector<double>& b) {
  if (b.empty()) return kNan;
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

// (SW4)
struct StructureTensor {
  double xx = 0.0, xy = 0.0, yy = 0.0;
  double trace() const { return xx + yy; }
  double smaller() const { return 0.5 * (trace() - std::hypot(xx - yy, 2.0 * xy)); }
};

StructureTensor TensorOf(const std::vector<double>& patch, int radius) {
  const int side = 2 * radius + 1;
  const double count = (side - 2) * (side - 2);
  StructureTensor tensor;
  for (int v = 1; v + 1 < side; ++v) {
    for (int u = 1; u + 1 < side; ++u) {
      const double* at = &patch[v * side + u];
      const double across = 0.5 * (at[1] - at[-1]), down = 0.5 * (at[side] - at[-side]);
      tensor.xx += across * across / count;
      tensor.xy += across * down / count;
      tensor.yy += down * down / count;
    }
  }
  return tensor;
}

void SweepPlace(const PlaneSweepInputs& inputs, int x, int y, const float* flow, float* out) {
  const int radius = inputs.patch_radius;
  const std::vector<double> p = PatchAt(inputs.first, x, y, 1.0, radius);
  std::fill_n(out, kSweepColumns, std::numeric_limits<float>::quiet_NaN());
  if (p.empty()) return;
  double least = std::numeric_limits<double>::infinity();
  for (size_t j = 0; j < inputs.steps.size(); ++j) {
    double at[3];
    for (size_t i = 0; i < 3; ++i) {
      const double* h = &inputs.homography[3 * i];
      at[i] = h[0] * x + h[1] * y + h[2] + inputs.steps[j].inverse_depth * inputs.epipole[i];
    }
    if (!(at[2] > 0.0)) continue;
    const double cost = SquaredDifference(
        p, PatchAt(inputs.second, at[0] / at[2], at[1] / at[2], inputs.steps[j].scale, radius));
    if (!(cost < least)) continue;
    least = cost;
    out[kStaticCost] = static_cast<float>(cost);
    out[kStaticStep] = static_cast<float>(j);
  }
  out[kFlowCost] = static_cast<float>(SquaredDifference(
      p, PatchAt(inputs.second, x + double{flow[0]}, y + double{flow[1]}, 1.0, radius)));
  const StructureTensor tensor = TensorOf(p, radius);
  out[kEnergy] = static_cast<float>(SquaredDifference(p, std::vector<double>(p.size(), 0.0)));
  out[kGradient] = static_cast<float>(tensor.trace());
  out[kLeastGradient] = static_cast<float>(tensor.smaller());
}

}  // namespace

void PlaneSweep(const PlaneSweepInputs& inputs, MatrixView<float> out) {
  const ImageGrid& grid = inputs.grid;
  int64_t i = 0;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column, ++i) {
      SweepPlace(inputs, grid.x_pixels(column), grid.y_pixels(row), inputs.flow.row(i), out.row(i));
    }
  }
}

}  // namespace egosieve::kernels::reference
