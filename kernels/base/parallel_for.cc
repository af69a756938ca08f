#include "kernels/base/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <system_error>
#include <thread>
#include <vector>

namespace egosieve::kernels {

void ParallelFor(int64_t count, const std::function<void(int64_t)>& body) {
  std::atomic<int64_t> next = 0;
  const auto work = [&] {
    for (int64_t i = next++; i < count; i = next++) body(i);
  };
  const int64_t helpers =
      std::min<int64_t>(count, std::max<int64_t>(std::thread::hardware_concurrency(), 1)) - 1;
  std::vector<std::thread> threads;
  try {
    for (int64_t i = 0; i < helpers; ++i) threads.emplace_back(work);
  } catch (const std::system_error&) {
    // No more threads to be had: those that are there, and this one, do the work.
  }
  work();
  for (std::thread& thread : threads) thread.join();
}

}  // namespace egosieve::kernels
