#include "kernels/base/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>
#include <new>
#include <numeric>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "gtest/gtest.h"

namespace egosieve::kernels {
namespace {

class ParallelForTest : public testing::Test {
 protected:
  void TearDown() override { SetMaximumThreads(0); }
};

// The threads that ran any of `count` tasks.
int64_t ThreadsOf(int64_t count, const ParallelLimits& limits) {
  std::mutex mutex;
  std::set<std::thread::id> threads;
  ParallelFor(count, limits, [&](int64_t) {
    const std::lock_guard<std::mutex> lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  return static_cast<int64_t>(threads.size());
}

TEST_F(ParallelForTest, CallsEveryIndexOnce) {
  for (const int threads : {1, 2, 7, 40}) {
    for (const int64_t count : {0, 1, 2, 3, 1000}) {
      std::vector<int> calls(count, 0);
      ParallelFor(count, ParallelLimits{.threads = threads}, [&](int64_t i) { ++calls[i]; });
      EXPECT_EQ(calls, std::vector<int>(count, 1));
    }
  }
}

TEST_F(ParallelForTest, Nests) {
  std::vector<int> calls(20 * 30, 0);
  ParallelFor(20, [&](int64_t i) { ParallelFor(30, [&](int64_t j) { ++calls[i * 30 + j]; }); });
  EXPECT_EQ(calls, std::vector<int>(20 * 30, 1));
}

TEST_F(ParallelForTest, OneThreadTakesTasksInOrder) {
  SetMaximumThreads(1);
  std::vector<int64_t> order;
  ParallelFor(100, [&](int64_t i) { order.push_back(i); });
  std::vector<int64_t> expected(100);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(order, expected);
}

// Would not end if a task could be taken before one of smaller index, and that one then by a thread
// that waits.
TEST_F(ParallelForTest, TasksMayWaitForThoseOfSmallerIndex) {
  for (const int threads : {1, 2, 3, 8, 64}) {
    constexpr int64_t kTasks = 2000;
    std::atomic<int64_t> ended = 0;
    ParallelFor(kTasks, ParallelLimits{.threads = threads}, [&](int64_t i) {
      while (ended < i) std::this_thread::yield();
      ended = i + 1;
    });
    EXPECT_EQ(ended, kTasks);
  }
}

TEST_F(ParallelForTest, LimitsHold) {
  EXPECT_GE(MaximumThreads(), 1);
  SetMaximumThreads(3);
  EXPECT_EQ(MaximumThreads(), 3);
  EXPECT_LE(ThreadsOf(1000, {}), 3);
  EXPECT_EQ(ThreadsOf(1000, {.threads = 1}), 1);
  EXPECT_LE(ThreadsOf(2, {.threads = 8}), 2);
  // Work for one thread.
  EXPECT_EQ(ThreadsOf(1000, {.threads = 8, .flops = 1000.0}), 1);
  EXPECT_EQ(ThreadsOf(1000, {.flops = std::numeric_limits<double>::quiet_NaN()}), 1);
  EXPECT_EQ(ThreadsOf(1000, {.flops = -1e9}), 1);
  SetMaximumThreads(1);
  EXPECT_EQ(ThreadsOf(1000, {}), 1);
  SetMaximumThreads(-5);
  EXPECT_EQ(MaximumThreads(), std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
}

// Every thread holds its task until as many have arrived as were asked for.
TEST_F(ParallelForTest, AsManyThreadsAsAskedForRunAtOnce) {
  std::atomic<int> arrived = 0;
  ParallelFor(4, ParallelLimits{.threads = 4}, [&](int64_t) {
    ++arrived;
    while (arrived < 4) std::this_thread::yield();
  });
  EXPECT_EQ(arrived, 4);
}

TEST_F(ParallelForTest, AnExceptionReachesTheCallerAndEndsTheTasks) {
  for (const int threads : {1, 2, 8}) {
    std::atomic<int64_t> calls = 0;
    EXPECT_THROW(ParallelFor(1000000, ParallelLimits{.threads = threads},
                             [&](int64_t i) {
                               ++calls;
                               if (i == 3) throw std::bad_alloc();
                             }),
                 std::bad_alloc);
    EXPECT_GE(calls, 4);
    EXPECT_LT(calls, 1000000);
    // Nested, and from every task at once.
    EXPECT_THROW(ParallelFor(8, ParallelLimits{.threads = threads},
                             [&](int64_t) {
                               ParallelFor(8, ParallelLimits{.threads = threads},
                                           [](int64_t) { throw std::runtime_error("each"); });
                             }),
                 std::runtime_error);
  }
}

}  // namespace
}  // namespace egosieve::kernels
