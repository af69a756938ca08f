#include "kernels/ops/local_tiles.h"

#include <algorithm>
#include <numeric>

namespace egosieve::kernels::opencl {
namespace {

// (1), in bytes.
int64_t StagedBytes(const KernelTuning& tuning, int64_t point_width) {
  const int64_t group = int64_t{tuning.panel} * tuning.panels_per_group;
  const int64_t queries = int64_t{tuning.width} * tuning.work_group / tuning.panels_per_group;
  const int64_t floats = std::max({group * (point_width + 1), tuning.depth * (group + queries),
                                   tuning.panels_per_group * queries});
  return floats * static_cast<int64_t>(sizeof(float));
}

// A divisor of panels_per_group remains a divisor of work_group. Tiles have twice the queries, of
// which fewer columns are staged at once where they would not fit.
KernelTuning WithSmallerBlocks(KernelTuning tuning, int64_t local_bytes) {
  const int panels = tuning.panels_per_group;
  tuning.panels_per_group = panels % 2 == 0 ? panels / 2 : 1;
  tuning.depth = std::gcd(tuning.depth, tuning.panel * tuning.panels_per_group);
  while (tuning.depth % 2 == 0 && StagedBytes(tuning, 0) > local_bytes) tuning.depth /= 2;
  return tuning;
}

}  // namespace

KernelTuning FitLocalMemory(const KernelTuning& tuning, int64_t point_width, int64_t local_bytes) {
  if (!tuning.local_tiles) return tuning;
  KernelTuning fitting = tuning;
  while (StagedBytes(fitting, point_width) > local_bytes) {
    const KernelTuning smaller = WithSmallerBlocks(fitting, local_bytes);
    if (smaller == fitting || !smaller.Validate().ok()) {
      KernelTuning scalar = DefaultTuning(1);
      scalar.work_group = 64;
      return scalar;
    }
    fitting = smaller;
  }
  return fitting;
}

int StagedPoints(int64_t point_width, int64_t local_bytes) {
  int points = 64;
  while (points > 1 &&
         points * (point_width + 1) * static_cast<int64_t>(sizeof(float)) > local_bytes)
    points /= 2;
  return points;
}

}  // namespace egosieve::kernels::opencl
