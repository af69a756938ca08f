#include "gp/linalg/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <system_error>
#include <thread>
#include <vector>

namespace egosieve::gp {
namespace {

int MachineThreads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

std::atomic<int> maximum_threads{0};

}  // namespace

void SetMaximumThreads(int threads) { maximum_threads = std::max(threads, 0); }

int MaximumThreads() {
  const int threads = maximum_threads;
  return threads > 0 ? threads : MachineThreads();
}

void ParallelFor(int64_t count, const std::function<void(int64_t)>& task) {
  std::atomic<int64_t> next{0};
  const auto work = [&] {
    for (int64_t i = next++; i < count; i = next++) task(i);
  };
  const int64_t threads = std::min<int64_t>(MaximumThreads(), count);
  std::vector<std::thread> helpers;
  for (int64_t t = 1; t < threads; ++t) {
    try {
      helpers.emplace_back(work);
    } catch (const std::system_error&) {
      break;  // the threads that there are do all the work
    }
  }
  work();
  for (std::thread& helper : helpers) helper.join();
}

}  // namespace egosieve::gp
