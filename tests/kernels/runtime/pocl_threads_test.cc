#include "kernels/runtime/pocl_threads.h"

#include <cstdlib>

#include "absl/strings/match.h"
#include "gtest/gtest.h"
#include "kernels/runtime/device.h"

namespace egosieve::kernels {
namespace {

TEST(PoclThreadsTest, PoclHasNoMoreThanTheLimit) {
  LimitPoclThreads(3);
  LimitPoclThreads(1);
  LimitPoclThreads(2);  // a limit from outside stays
  EXPECT_STREQ(std::getenv("POCL_MAX_PTHREAD_COUNT"), "1");
  EXPECT_STREQ(std::getenv("POCL_CPU_MAX_CU_COUNT"), "1");
  const auto devices = ListDevices();
  ASSERT_TRUE(devices.ok()) << devices.status();
  for (const DeviceInfo& device : *devices) {
    if (device.type == DeviceType::kCpu && absl::StrContains(device.platform, "Portable")) {
      EXPECT_EQ(device.compute_units, 1) << device.name;
    }
  }
}

}  // namespace
}  // namespace egosieve::kernels
