#include "kernels/base/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace egosieve::kernels {
namespace {

// What a thread should have to do before it is started: about a tenth of a millisecond's work.
constexpr double kFlopsPerThread = 5e6;

int MachineThreads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

std::atomic<int> maximum_threads{0};

// NaN counts as little work.
int64_t WorthwhileThreads(double flops) {
  const double threads = 1.0 + flops / kFlopsPerThread;
  constexpr int64_t kMany = 1 << 20;
  return threads >= kMany ? kMany : threads >= 1.0 ? static_cast<int64_t>(threads) : 1;
}

}  // namespace

void SetMaximumThreads(int threads) { maximum_threads = std::max(threads, 0); }

int MaximumThreads() {
  const int threads = maximum_threads;
  return threads > 0 ? threads : MachineThreads();
}

void ParallelFor(int64_t count, const ParallelLimits& limits,
                 const std::function<void(int64_t)>& task) {
  std::atomic<int64_t> next{0};
  std::mutex mutex;
  std::exception_ptr thrown;  // guarded by mutex
  const auto work = [&] {
    for (int64_t i = next++; i < count; i = next++) {
      try {
        task(i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        if (!thrown) thrown = std::current_exception();
        next = count;
      }
    }
  };
  const int most = limits.threads > 0 ? limits.threads : MaximumThreads();
  const int64_t threads = std::min<int64_t>({most, count, WorthwhileThreads(limits.flops)});
  std::vector<std::thread> helpers;
  try {
    helpers.reserve(std::max<int64_t>(threads, 1) - 1);
    for (int64_t t = 1; t < threads; ++t) helpers.emplace_back(work);
  } catch (const std::exception&) {
    // Neither a thread nor memory for one: those that there are do all the work.
  }
  work();
  for (std::thread& helper : helpers) helper.join();
  if (thrown) std::rethrow_exception(thrown);
}

void ParallelFor(int64_t count, double flops, const std::function<void(int64_t)>& task) {
  ParallelFor(count, ParallelLimits{.flops = flops}, task);
}

void ParallelFor(int64_t count, const std::function<void(int64_t)>& task) {
  ParallelFor(count, ParallelLimits{}, task);
}

}  // namespace egosieve::kernels
