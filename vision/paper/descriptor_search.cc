#include "vision/paper/descriptor_search.h"

#include <algorithm>

#include "kernels/base/parallel_for.h"
#include "vision/paper/feature_set.h"

namespace egosieve::vision {
namespace {

constexpr int kBytes = kSiftDescriptorBytes;
constexpr int64_t kRowsPerTask = 256;

// For each a its two nearest b.
std::vector<Nearest> TwoNearest(const uint8_t* a, int64_t rows, const uint8_t* b, int64_t columns,
                                int threads) {
  std::vector<Nearest> all(rows);
  const int64_t tasks = (rows + kRowsPerTask - 1) / kRowsPerTask;
  kernels::ParallelFor(tasks, {.threads = threads}, [&](int64_t task) {
    for (int64_t i = task * kRowsPerTask; i < std::min((task + 1) * kRowsPerTask, rows); ++i) {
      Nearest& nearest = all[i];
      for (int64_t j = 0; j < columns; ++j) {
        const int32_t distance = SquaredDistance(a + i * kBytes, b + j * kBytes);
        if (distance < nearest.distance) {
          nearest = {static_cast<int32_t>(j), distance, nearest.distance};
        } else {
          nearest.second_distance = std::min(nearest.second_distance, distance);
        }
      }
    }
  });
  return all;
}

}  // namespace

int32_t SquaredDistance(const uint8_t* a, const uint8_t* b) {
  int32_t sum = 0;
  for (int k = 0; k < kBytes; ++k) {
    const int32_t difference = static_cast<int32_t>(a[k]) - static_cast<int32_t>(b[k]);
    sum += difference * difference;
  }
  return sum;
}

NearestBothWays SearchDescriptors(const uint8_t* a, int64_t rows, const uint8_t* b, int64_t columns,
                                  int threads) {
  NearestBothWays result;
  result.rows = TwoNearest(a, rows, b, columns, threads);
  for (const Nearest& nearest : TwoNearest(b, columns, a, rows, threads)) {
    result.columns.push_back(nearest.index);
  }
  return result;
}

}  // namespace egosieve::vision
