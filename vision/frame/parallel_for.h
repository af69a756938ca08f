// Runs body(0) .. body(count - 1), each exactly once, on up to `threads` threads of this call, the
// caller's among them. Bodies must write to places of their own: then results do not depend on the
// number of threads.
#ifndef EGOSIEVE_VISION_FRAME_PARALLEL_FOR_H_
#define EGOSIEVE_VISION_FRAME_PARALLEL_FOR_H_

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace egosieve::vision {

template <typename Body>
void ParallelFor(int threads, int64_t count, const Body& body) {
  std::atomic<int64_t> next{0};
  const auto work = [&] {
    for (int64_t i = next.fetch_add(1); i < count; i = next.fetch_add(1)) body(i);
  };
  std::vector<std::jthread> helpers;
  const int64_t wanted = std::min<int64_t>(threads, count) - 1;
  for (int64_t t = 0; t < wanted; ++t) helpers.emplace_back(work);
  work();
}

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_PARALLEL_FOR_H_
