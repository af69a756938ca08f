// Runs independent work for each of many points on several threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "kernels/base/parallel_for.h"

namespace egosieve::vision {

// Calls work(0), ..., work(count - 1). No two calls may write to the same memory.
template <typename Work>
void ForEachPoint(size_t count, const Work& work) {
  constexpr size_t kStretch = 512;  // about a millisecond
  const size_t stretches = (count + kStretch - 1) / kStretch;
  kernels::ParallelFor(static_cast<int64_t>(stretches), [&](int64_t stretch) {
    const size_t first = static_cast<size_t>(stretch) * kStretch;
    for (size_t i = first; i < std::min(count, first + kStretch); ++i) work(i);
  });
}

}  // namespace egosieve::vision
