#include "kernels/runtime/device.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/base/parallel_for.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/opencl_context.h"
#include "kernels/runtime/opencl_error.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

std::vector<DeviceInfo> MadeUpDevices() {
  std::vector<DeviceInfo> devices(4);
  devices[0].name = "Fast Processor";
  devices[0].type = DeviceType::kCpu;
  devices[1].name = "Great Graphics 9000";
  devices[1].type = DeviceType::kGpu;
  devices[2].name = "Other Graphics";
  devices[2].type = DeviceType::kGpu;
  devices[3].name = "reference";
  devices[3].type = DeviceType::kReference;
  for (int i = 0; i < 4; ++i) devices[i].index = i;
  return devices;
}

int ChosenIndex(const std::vector<DeviceInfo>& devices, const std::string& choice) {
  const auto chosen = ChooseDevice(devices, choice);
  return chosen.ok() ? chosen->index : -1;
}

TEST(ChooseDevice, TakesIndexTypeOrPartOfAName) {
  const std::vector<DeviceInfo> devices = MadeUpDevices();
  EXPECT_EQ(ChosenIndex(devices, ""), 1);
  EXPECT_EQ(ChosenIndex(devices, "0"), 0);
  EXPECT_EQ(ChosenIndex(devices, "2"), 2);
  EXPECT_EQ(ChosenIndex(devices, "cpu"), 0);
  EXPECT_EQ(ChosenIndex(devices, "GPU"), 1);
  EXPECT_EQ(ChosenIndex(devices, "other"), 2);
  EXPECT_EQ(ChosenIndex(devices, "graphics"), 1);
  EXPECT_EQ(ChosenIndex(devices, "reference"), 3);
}

TEST(ChooseDevice, WithoutAGpuTheCpuIsTheDefault) {
  std::vector<DeviceInfo> devices = MadeUpDevices();
  devices.erase(devices.begin() + 1, devices.begin() + 3);
  EXPECT_EQ(ChosenIndex(devices, ""), 0);
}

TEST(ChooseDevice, UnknownChoicesListWhatThereIs) {
  for (const char* choice : {"4", "-1", "99999999999999999999", "tpu"}) {
    const auto chosen = ChooseDevice(MadeUpDevices(), choice);
    EXPECT_EQ(chosen.status().code(), absl::StatusCode::kNotFound) << choice;
    EXPECT_THAT(chosen.status().message(), testing::HasSubstr("Great Graphics 9000"));
  }
}

TEST(ChooseDevice, WithoutAnyDeviceItSaysWhatToInstall) {
  setenv("OCL_ICD_VENDORS", "/nowhere", 1);
  const std::vector<DeviceInfo> reference_only(1, MadeUpDevices()[3]);
  const auto chosen = ChooseDevice(reference_only, "");
  EXPECT_EQ(chosen.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(chosen.status().message(), testing::HasSubstr("pocl-opencl-icd"));
  EXPECT_EQ(ChosenIndex(reference_only, "reference"), 3);
  unsetenv("OCL_ICD_VENDORS");
}

TEST(ListDevices, EndsWithTheReferenceAndNumbersItsElements) {
  const auto devices = Value(ListDevices());
  ASSERT_FALSE(devices.empty());
  for (size_t i = 0; i < devices.size(); ++i) {
    const DeviceInfo& device = devices[i];
    EXPECT_EQ(device.index, static_cast<int>(i));
    EXPECT_FALSE(device.name.empty());
    EXPECT_EQ(device.type == DeviceType::kReference, i + 1 == devices.size());
    if (device.type != DeviceType::kReference) {
      EXPECT_GT(device.compute_units, 0);
      EXPECT_GT(device.memory_bytes, 0);
      EXPECT_FALSE(device.vendor.empty());
      EXPECT_FALSE(device.version.empty());
    }
  }
}

TEST(OpenContext, OptionsGoBeforeTheEnvironment) {
  const char* old = std::getenv("EGOSIEVE_DEVICE");
  const std::string saved = old == nullptr ? "" : old;
  setenv("EGOSIEVE_DEVICE", "no such device", 1);
  EXPECT_EQ(OpenContext().status().code(), absl::StatusCode::kNotFound);
  ContextOptions options;
  options.device = "reference";
  const auto context = Value(OpenContext(options));
  EXPECT_TRUE(context->is_reference());
  if (old == nullptr) {
    unsetenv("EGOSIEVE_DEVICE");
  } else {
    setenv("EGOSIEVE_DEVICE", saved.c_str(), 1);
  }
}

TEST(OpenClErrors, BecomeStatusesWithCallAndCode) {
  const absl::Status status = CatchOpenClErrors(
      "doing this", [] { throw cl::Error(CL_OUT_OF_RESOURCES, "clEnqueueNDRangeKernel"); });
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(status.message(), "doing this: clEnqueueNDRangeKernel failed with CL_OUT_OF_RESOURCES");
  EXPECT_EQ(CatchOpenClErrors("x", [] { throw cl::Error(CL_DEVICE_NOT_AVAILABLE, "y"); }).code(),
            absl::StatusCode::kUnavailable);
  EXPECT_EQ(CatchOpenClErrors("x", [] { throw cl::Error(-77777, "y"); }).message(),
            "x: y failed with OpenCL error -77777");
  EXPECT_EQ(CatchOpenClErrors("x", [] { throw std::bad_alloc(); }).code(),
            absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(CatchOpenClErrors("x", [] {}).ok());
}

TEST(Context, BuildErrorsCarryTheCompilersLogAndTheContextStaysUsable) {
  const auto context = Value(OpenContext());
  if (context->is_reference()) GTEST_SKIP() << "the reference compiles nothing";
  const auto kernel =
      context->Kernel("image.cl", "-cl-std=CL1.2 -DVEC=1 -DCHANNELS=oops", "box_means_on_grid");
  ASSERT_FALSE(kernel.ok());
  EXPECT_THAT(kernel.status().message(), testing::HasSubstr("clBuildProgram"));
  EXPECT_THAT(kernel.status().message(), testing::HasSubstr("oops"));
  const std::string good = "-cl-std=CL1.2 -DVEC=1 -DCHANNELS=3";
  EXPECT_TRUE(context->Kernel("image.cl", good, "box_means_on_grid").ok());
  EXPECT_FALSE(context->Kernel("image.cl", good, "no_such_kernel").ok());
}

// Processor time of every thread of this process, in clock ticks, by its number.
std::map<std::string, int64_t> TicksOfThreads() {
  std::map<std::string, int64_t> ticks;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream file(task.path() / "stat");
    std::string text((std::istreambuf_iterator<char>(file)), {});
    // Fields 14 and 15, user and system time; the name, field 2, ends with the last bracket.
    std::istringstream fields(text.substr(text.rfind(')') + 1));
    std::string field;
    for (int i = 3; i < 14; ++i) fields >> field;
    int64_t user = 0, system = 0;
    fields >> user >> system;
    ticks[task.path().filename()] = user + system;
  }
  return ticks;
}

// Threads beside this one that worked on a covariance matrix of so many points.
int64_t ThreadsAtWork(Context& context, int64_t points) {
  const std::vector<double> x(points, 0.5);
  std::vector<double> out(points * points);
  const CovarianceParameters parameters{CovarianceFunction::kSquaredExponential, {0.3}};
  const auto compute = [&] {
    return CrossCovariance<double>(context, parameters, {x.data(), points, 1},
                                   {x.data(), points, 1}, {out.data(), points, points});
  };
  EXPECT_TRUE(compute().ok());  // compiles
  const auto before = TicksOfThreads();
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(compute().ok());
  int64_t threads = 0;
  for (const auto& [thread, ticks] : TicksOfThreads()) {
    const auto found = before.find(thread);
    const int64_t worked = ticks - (found == before.end() ? 0 : found->second);
    threads += thread != std::to_string(getpid()) && worked >= 5;
  }
  return threads;
}

TEST(Context, TheLimitOfThreadsHoldsForEachCallOnACpu) {
  const auto context = Value(OpenContext());
  const DeviceInfo& device = context->info();
  if (device.type != DeviceType::kCpu || device.compute_units < 2) {
    GTEST_SKIP() << device.name << " is not a CPU with several compute units";
  }
  SetMaximumThreads(2);
  EXPECT_EQ(ThreadsAtWork(*context, 4000), 2);
  SetMaximumThreads(1);
  EXPECT_EQ(ThreadsAtWork(*context, 4000), 1);
  SetMaximumThreads(2);
  EXPECT_EQ(ThreadsAtWork(*context, 4000), 2);
  SetMaximumThreads(0);
}

}  // namespace
}  // namespace egosieve::kernels
