#include "kernels/base/processors.h"

#include <sched.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "gtest/gtest.h"
#include "kernels/base/parallel_for.h"

namespace egosieve::kernels {
namespace {

namespace fs = std::filesystem;

class ProcessorQuotaTest : public testing::Test {
 protected:
  ProcessorQuotaTest()
      : root_(testing::TempDir() + "/cgroup_" +
              testing::UnitTest::GetInstance()->current_test_info()->name()) {
    fs::remove_all(root_);
    fs::create_directories(root_);
  }

  void Write(const std::string& path, const std::string& text) {
    fs::create_directories(fs::path(root_ + path).parent_path());
    std::ofstream(root_ + path) << text << "\n";
  }

  std::string root_;
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
