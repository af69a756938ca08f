#include "kernels/base/parallel_for.h"

#include <sched.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <mutex>
#include <new>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/base/processors.h"
#include "tests/testing/fresh_folder.h"

namespace egosieve::kernels {
namespace {

namespace fs = std::filesystem;
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
  EXPECT_EQ(MaximumThreads(), AvailableProcessors());
}

// Every thread holds its task until as many have arrived as were asked for.
void Meet(int threads) {
  std::atomic<int> arrived = 0;
  ParallelFor(threads, ParallelLimits{.threads = threads}, [&](int64_t) {
    ++arrived;
    while (arrived < threads) std::this_thread::yield();
  });
}

TEST_F(ParallelForTest, AsManyThreadsAsAskedForRunAtOnce) { Meet(4); }

// The process's threads, this one included.
int64_t ProcessThreads() {
  int64_t threads = 0;
  for ([[maybe_unused]] const auto& entry :
       std::filesystem::directory_iterator("/proc/self/task")) {
    ++threads;
  }
  return threads;
}

TEST_F(ParallelForTest, ThreadsAreKeptAndUsedAgain) {
  Meet(4);
  const int64_t threads = ProcessThreads();
  for (int call = 0; call < 1000; ++call) Meet(4);
  EXPECT_EQ(ProcessThreads(), threads);
}

TEST_F(ParallelForTest, CallsFromManyThreadsDoNotMeet) {
  std::vector<std::thread> callers;
  std::vector<int64_t> sums(6, 0);
  for (int64_t& sum : sums) {
    callers.emplace_back([&sum] {
      for (int call = 0; call < 200; ++call) {
        std::vector<int64_t> results(37, 0);
        ParallelFor(37, ParallelLimits{.threads = 3}, [&](int64_t i) { results[i] = i + 1; });
        sum += std::accumulate(results.begin(), results.end(), int64_t{0});
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(sums, std::vector<int64_t>(6, 200 * 37 * 38 / 2));
}

// Would wait for ever if the child took its parent's threads for its own.
TEST_F(ParallelForTest, AForkedChildHasItsOwnThreads) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "ThreadSanitizer starts no thread in a child";
#endif
  Meet(2);
  EXPECT_EXIT(
      {
        alarm(30);
        Meet(2);
        _exit(0);
      },
      testing::ExitedWithCode(0), "");
  Meet(2);
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

class ProcessorQuotaTest : public testing::Test {
 protected:
  void Write(const std::string& path, const std::string& text) {
    fs::create_directories(fs::path(root_ + path).parent_path());
    std::ofstream(root_ + path) << text << "\n";
  }

  const std::string root_ = FreshFolder();
};

TEST_F(ProcessorQuotaTest, NoneWhereNothingSaysSo) {
  EXPECT_TRUE(std::isinf(ProcessorQuota("", root_)));
  EXPECT_TRUE(std::isinf(ProcessorQuota("0::/job\n", root_)));
  EXPECT_TRUE(std::isinf(ProcessorQuota("no line of a membership\n1:\n", root_)));
  Write("/job/cpu.max", "max 100000");
  EXPECT_TRUE(std::isinf(ProcessorQuota("0::/job\n", root_)));
  Write("/cpu/cpu.cfs_quota_us", "-1");
  Write("/cpu/cpu.cfs_period_us", "100000");
  EXPECT_TRUE(std::isinf(ProcessorQuota("1:cpu:/\n", root_)));
}

TEST_F(ProcessorQuotaTest, TheLeastOfAGroupAndThoseAboveIt) {
  Write("/cpu.max", "800000 100000");
  Write("/slice/cpu.max", "150000 100000");
  Write("/slice/job/cpu.max", "max 100000");
  EXPECT_EQ(ProcessorQuota("0::/slice/job\n", root_), 1.5);
  EXPECT_EQ(ProcessorQuota("0::/other\n", root_), 8.0);
}

TEST_F(ProcessorQuotaTest, VersionOneNamesItsControllers) {
  Write("/cpu,cpuacct/job/cpu.cfs_quota_us", "50000");
  Write("/cpu,cpuacct/job/cpu.cfs_period_us", "100000");
  EXPECT_EQ(ProcessorQuota("4:memory:/job\n3:cpu,cpuacct:/job\n0::/\n", root_), 0.5);
  EXPECT_TRUE(std::isinf(ProcessorQuota("3:cpuset:/job\n", root_)));
}

// As Docker has it: the group's own folder is mounted as the root, its path is the host's.
TEST_F(ProcessorQuotaTest, AContainersRootIsItsGroup) {
  Write("/cpu/cpu.cfs_quota_us", "300000");
  Write("/cpu/cpu.cfs_period_us", "100000");
  EXPECT_EQ(ProcessorQuota("3:cpu:/docker/0123\n", root_), 3.0);
}

int StayOnOneProcessor() {
  cpu_set_t allowed, one;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0) return -1;
  int processor = 0;
  while (!CPU_ISSET(processor, &allowed)) ++processor;
  CPU_ZERO(&one);
  CPU_SET(processor, &one);
  return sched_setaffinity(0, sizeof(one), &one);
}

// In programs of their own, which ask for the first time.
class MaximumThreadsTest : public testing::Test {
 protected:
  MaximumThreadsTest() { testing::FLAGS_gtest_death_test_style = "threadsafe"; }
};

TEST_F(MaximumThreadsTest, IsWhatTheProcessMayUse) {
  EXPECT_GE(AvailableProcessors(), 1);
  EXPECT_EXIT(
      {
        StayOnOneProcessor();
        std::_Exit(AvailableProcessors() == 1 ? MaximumThreads() : 100);
      },
      testing::ExitedWithCode(1), "");
}

TEST_F(MaximumThreadsTest, IsWhatTheEnvironmentSays) {
  const auto threads_with = [](const char* environment) {
    setenv("EGOSIEVE_THREADS", environment, 1);
    std::_Exit(MaximumThreads());
  };
  EXPECT_EXIT(threads_with("5"), testing::ExitedWithCode(5), "");
  EXPECT_EXIT(threads_with("many"), testing::ExitedWithCode(AvailableProcessors()), "");
  EXPECT_EXIT(threads_with("-3"), testing::ExitedWithCode(AvailableProcessors()), "");
}

}  // namespace
}  // namespace egosieve::kernels
