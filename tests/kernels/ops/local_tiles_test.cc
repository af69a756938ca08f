// Shapes for points of every width: they fit the local memory, and use it as long as it is enough.
#include "kernels/ops/local_tiles.h"

#include <algorithm>

#include "gtest/gtest.h"
#include "kernels/runtime/tuning.h"

namespace egosieve::kernels::opencl {
namespace {

constexpr int64_t kUsualBytes = 48 << 10;

// Bytes of the array `stage` of kernels/cl/dense_posterior_local.cl, with a factor and without.
int64_t StageBytes(const KernelTuning& tuning, int64_t width, int64_t local_bytes) {
  const int64_t group = tuning.panel * tuning.panels_per_group;
  const int64_t queries = tuning.width * (tuning.work_group / tuning.panels_per_group);
  const int64_t with_factor = std::max(
      {group * width, tuning.depth * (group + queries), tuning.panels_per_group * queries});
  return 4 * std::max(with_factor, StagedPoints(width, local_bytes) * (width + 1));
}

TEST(LocalTiles, NarrowPointsKeepTheDevicesShape) {
  for (const int64_t width : {1, 8, 33, 95}) {
    EXPECT_EQ(FitLocalMemory(DefaultGpuTuning(), width, kUsualBytes), DefaultGpuTuning());
    EXPECT_EQ(StagedPoints(width, kUsualBytes), 64);
  }
}

TEST(LocalTiles, WidePointsTakeSmallerBlocks) {
  // The last width at which 128, 64, 32, 16 and 8 rows of P + 1 values fit in 12,288 floats.
  const int64_t last[] = {95, 191, 383, 767, 1535};
  const int depth[] = {8, 8, 8, 8, 4};  // that of 8 rows by 2,048 queries takes 66 KB with 8
  int panels = DefaultGpuTuning().panels_per_group, points = 64;
  for (int i = 1; i < 5; ++i) {
    panels /= 2;
    if (i > 1) points /= 2;
    KernelTuning expected = DefaultGpuTuning();
    expected.panels_per_group = panels;
    expected.depth = depth[i];
    for (const int64_t width : {last[i - 1] + 1, last[i]}) {
      EXPECT_EQ(FitLocalMemory(DefaultGpuTuning(), width, kUsualBytes), expected) << width;
      EXPECT_EQ(StagedPoints(width, kUsualBytes), points) << width;
    }
  }
}

TEST(LocalTiles, ThoseThatNeverFitTakeWorkItemsSideBySide) {
  KernelTuning scalar = DefaultTuning(1);
  scalar.work_group = 64;
  EXPECT_EQ(FitLocalMemory(DefaultGpuTuning(), 1536, kUsualBytes), scalar);
  EXPECT_EQ(FitLocalMemory(DefaultGpuTuning(), 1, 1024), scalar);
  EXPECT_TRUE(scalar.Validate().ok());
}

TEST(LocalTiles, OtherShapesStayAsTheyAre) {
  for (const int lanes : {1, 4, 8, 16}) {
    EXPECT_EQ(FitLocalMemory(DefaultTuning(lanes), 5000, 1024), DefaultTuning(lanes));
  }
}

// Also of a table with numbers that are no powers of two.
TEST(LocalTiles, EveryShapeIsValidAndFits) {
  KernelTuning odd = DefaultGpuTuning();
  odd.panel = 3;
  odd.panels_per_group = 24;
  odd.depth = 36;
  odd.work_group = 96;
  ASSERT_TRUE(odd.Validate().ok());
  for (const KernelTuning& tuning : {DefaultGpuTuning(), odd}) {
    for (const int64_t bytes : {int64_t{16} << 10, int64_t{32} << 10, kUsualBytes}) {
      for (int64_t width = 1; width < 3000; width += 7) {
        const KernelTuning fitting = FitLocalMemory(tuning, width, bytes);
        ASSERT_TRUE(fitting.Validate().ok()) << width << ": " << fitting.Validate();
        if (!fitting.local_tiles) continue;
        ASSERT_LE(StageBytes(fitting, width, bytes), bytes) << width;
      }
    }
  }
}

}  // namespace
}  // namespace egosieve::kernels::opencl
