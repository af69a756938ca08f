#include "kernels/base/parallel_for.h"

#include <vector>

#include "gtest/gtest.h"

namespace egosieve::kernels {
namespace {

TEST(ParallelFor, CallsEveryIndexOnce) {
  for (const int64_t count : {0, 1, 2, 3, 1000}) {
    std::vector<int> calls(count, 0);
    ParallelFor(count, [&](int64_t i) { ++calls[i]; });
    EXPECT_EQ(calls, std::vector<int>(count, 1));
  }
}

TEST(ParallelFor, Nests) {
  std::vector<int> calls(20 * 30, 0);
  ParallelFor(20, [&](int64_t i) { ParallelFor(30, [&](int64_t j) { ++calls[i * 30 + j]; }); });
  EXPECT_EQ(calls, std::vector<int>(20 * 30, 1));
}

}  // namespace
}  // namespace egosieve::kernels
