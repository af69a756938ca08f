#include "vision/paper/descriptor_search.h"

#include <algorithm>

#include "kernels/base/parallel_for.h"
#include "vision/paper/feature_set.h"

namespace egosieve::vision {
namespace {

constexpr int kBytes = kSiftDescriptorBytes;
constexpr int64_t kRowsPerTask = 256;

struct ColumnBest {
  std::vector<int32_t> distance, index;
  explicit ColumnBest(int64_t n) : distance(n, kNoDistance), index(n, -1) {}
};

void SearchRows(const uint8_t* a, int64_t begin, int64_t end, const uint8_t* b, int64_t columns,
                Nearest* rows, ColumnBest& best) {
  for (int64_t i = begin; i < end; ++i) {
    Nearest nearest;
    for (int64_t j = 0; j < columns; ++j) {
      const int32_t distance = SquaredDistance(a + i * kBytes, b + j * kBytes);
      if (distance < nearest.distance) {
        nearest.second_distance = nearest.distance;
        nearest.distance = distance;
        nearest.index = static_cast<int32_t>(j);
      } else {
        nearest.second_distance = std::min(nearest.second_distance, distance);
      }
      if (distance < best.distance[j]) {
        best.distance[j] = distance;
        best.index[j] = static_cast<int32_t>(i);
      }
    }
    rows[i] = nearest;
  }
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
  result.rows.resize(rows);
  result.columns.assign(columns, -1);
  if (rows == 0 || columns == 0) return result;
  const int64_t tasks = (rows + kRowsPerTask - 1) / kRowsPerTask;
  std::vector<ColumnBest> best(tasks, ColumnBest(columns));
  kernels::ParallelFor(tasks, {.threads = threads}, [&](int64_t task) {
    const int64_t begin = task * kRowsPerTask;
    SearchRows(a, begin, std::min(begin + kRowsPerTask, rows), b, columns, result.rows.data(),
               best[task]);
  });
  std::vector<int32_t> distance(columns, kNoDistance);
  for (const ColumnBest& task : best) {
    for (int64_t j = 0; j < columns; ++j) {
      if (task.distance[j] < distance[j]) {
        distance[j] = task.distance[j];
        result.columns[j] = task.index[j];
      }
    }
  }
  return result;
}

}  // namespace egosieve::vision
