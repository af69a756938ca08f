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

#include "absl/strings/str_split.h"
#include "kernels/base/parallel_for.h"
#include "kernels/cl/sources.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/driver_check.h"
#include "kernels/runtime/opencl_context.h"
#include "kernels/runtime/opencl_error.h"
#include "kernels/runtime/tuning.h"
#include "tests/kernels/scoped_variable.h"
#include "tests/testing/fresh_folder.h"
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
  EXPECT_THAT(chosen.status(), IsError(absl::StatusCode::kNotFound, "pocl-opencl-icd"));
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
  const ScopedVariable device("EGOSIEVE_DEVICE", "no such device");
  EXPECT_EQ(OpenContext().status().code(), absl::StatusCode::kNotFound);
  const auto context = Value(OpenContext({.device = "reference"}));
  EXPECT_TRUE(context->is_reference());
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
      context->Kernel("roofline.cl", "-cl-std=CL1.2 -DVEC=1 -DCHAINS=oops", "multiply_add");
  ASSERT_FALSE(kernel.ok());
  EXPECT_THAT(kernel.status().message(), testing::HasSubstr("clBuildProgram"));
  EXPECT_THAT(kernel.status().message(), testing::HasSubstr("oops"));
  const std::string good = "-cl-std=CL1.2 -DVEC=1 -DCHAINS=3";
  EXPECT_TRUE(context->Kernel("roofline.cl", good, "multiply_add").ok());
  EXPECT_FALSE(context->Kernel("roofline.cl", good, "no_such_kernel").ok());
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
    return CrossCovariance(context, parameters, {x.data(), points, 1}, {x.data(), points, 1},
                           {out.data(), points, points});
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

TEST(Context, ThePartOfACpuOutlivesTheContextsThatUseIt) {
  const auto context = Value(OpenContext());
  if (context->info().type != DeviceType::kCpu || context->info().compute_units < 2) {
    GTEST_SKIP() << context->info().name << " is not a CPU with several compute units";
  }
  SetMaximumThreads(1);
  const auto part = [] { return Value(Value(OpenContext())->Borrow("a test"))->device()(); };
  const cl_device_id first = part();
  EXPECT_EQ(Value(context->Borrow("a test"))->device()(), first);
  EXPECT_EQ(part(), first);
  SetMaximumThreads(0);
}

class DriverCheck : public testing::Test {
 protected:
  void SetUp() override { setenv("OCL_ICD_VENDORS", folder_.c_str(), 1); }

  void Install(const std::string& library) const {
    std::ofstream(folder_ + "/driver.icd") << library << "\n";
  }
  bool Says(const std::string& text) const {
    const std::string why = WhyNoDevice();
    EXPECT_THAT(why, testing::HasSubstr("\"reference\""));
    if (why.find(text) != std::string::npos) return true;
    ADD_FAILURE() << why;
    return false;
  }

  const std::string folder_ = FreshFolder();
};

TEST_F(DriverCheck, NothingInstalledSaysWhatToInstall) {
  EXPECT_TRUE(Says("install an OpenCL driver"));
  setenv("OCL_ICD_VENDORS", "/nowhere", 1);
  EXPECT_TRUE(Says("install an OpenCL driver"));
}

TEST_F(DriverCheck, ADriverThatDoesNotLoadIsNamedWithTheReason) {
  Install("/nowhere/libdriver.so");
  EXPECT_TRUE(Says("driver.icd does not load (/nowhere/libdriver.so: cannot open"));
}

TEST_F(DriverCheck, ADriverWithoutDevicesIsNotToBeInstalled) {
  Install("libc.so.6");
  EXPECT_TRUE(Says("libc.so.6 is installed and gives no device"));
  setenv("POCL_CACHE_DIR", "/some/cache", 1);
  EXPECT_TRUE(Says("/some/cache"));
}

TEST_F(DriverCheck, PoclIsNotStartedWhereItWouldAbort) {
  EXPECT_TRUE(CheckDriversCanStart("/nowhere").ok()) << "no driver is installed";
  Install("libother.so.1");
  EXPECT_TRUE(CheckDriversCanStart("/nowhere").ok()) << "others need no list of processors";
  Install("libpocl.so.2");
  EXPECT_TRUE(CheckDriversCanStart(testing::TempDir()).ok());
  const absl::Status status = CheckDriversCanStart("/nowhere");
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  EXPECT_THAT(status.message(), testing::HasSubstr("libpocl.so.2"));
  EXPECT_THAT(status.message(), testing::HasSubstr("mount /sys"));
}

// A table of kernel shapes in the user's cache folder would decide what tests run.
TEST(CacheFolder, ThatOfTestsIsNotTheUsers) {
  EXPECT_EQ(CacheFolder(), "/dev/null/none");
  EXPECT_FALSE(SaveTuning(ReferenceDevice(), DefaultTuning(4)).ok());
}

TEST(CacheFolder, TheMostSpecificVariableWins) {
  const ScopedVariable home("HOME", "/h"), cache("XDG_CACHE_HOME"), own("EGOSIEVE_CACHE_DIR");
  unsetenv("XDG_CACHE_HOME");
  unsetenv("EGOSIEVE_CACHE_DIR");
  EXPECT_EQ(CacheFolder(), "/h/.cache/egosieve");
  setenv("XDG_CACHE_HOME", "/x", 1);
  EXPECT_EQ(CacheFolder(), "/x/egosieve");
  setenv("EGOSIEVE_CACHE_DIR", "/e", 1);
  EXPECT_EQ(CacheFolder(), "/e");
  setenv("EGOSIEVE_CACHE_DIR", "", 1);
  EXPECT_EQ(CacheFolder(), "/x/egosieve");
  unsetenv("XDG_CACHE_HOME");
  unsetenv("HOME");
  EXPECT_EQ(CacheFolder(), "");
}

TEST(HashBytes, IsFnv1a) {
  EXPECT_EQ(HashBytes(""), 0xcbf29ce484222325u);
  EXPECT_EQ(HashBytes("a"), 0xaf63dc4c8601ec8cu);
  EXPECT_EQ(HashBytes("foobar"), 0x85944171f73967e8u);
}

TEST(Tuning, ATableIsReadBackForItsDeviceAlone) {
  const ScopedVariable folder("EGOSIEVE_CACHE_DIR", testing::TempDir() + "/tables");
  DeviceInfo device;
  device.name = "A device";
  DeviceInfo other = device;
  other.driver = "newer";
  KernelTuning tuning = DefaultTuning(8);
  EXPECT_EQ(LoadTuning(device, tuning), tuning);
  tuning.depth = 77;
  tuning.panel = 5;
  ASSERT_TRUE(SaveTuning(device, tuning).ok());
  EXPECT_EQ(LoadTuning(device, DefaultTuning(16)), tuning);
  EXPECT_EQ(LoadTuning(other, DefaultTuning(16)), DefaultTuning(16));
}

TEST(Tuning, DamagedTablesAreIgnored) {
  const KernelTuning defaults = DefaultTuning(16);
  for (const char* text : {"", "panel", "panel x", "panel 0", "panel 1000", "float_lanes 5",
                           "\xff\xfe\n\0", "panel 8 9", "unknown 3\n"}) {
    EXPECT_EQ(ParseTuning(text, defaults), defaults) << text;
  }
  EXPECT_EQ(ParseTuning("nonsense\npanel 9\nnonsense", defaults).panel, 9);
}

TEST(Tuning, DefaultsAreValid) {
  for (const int lanes : {1, 4, 8, 16}) EXPECT_TRUE(DefaultTuning(lanes).Validate().ok()) << lanes;
  EXPECT_TRUE(DefaultGpuTuning().Validate().ok());
  using Misfit = std::pair<int KernelTuning::*, int>;
  for (const auto& [field, value] :
       {Misfit{&KernelTuning::float_lanes, 4}, Misfit{&KernelTuning::work_group, 100},
        Misfit{&KernelTuning::panels_per_group, 12}, Misfit{&KernelTuning::depth, 24}}) {
    KernelTuning tuning = DefaultGpuTuning();
    tuning.*field = value;
    EXPECT_THAT(tuning.Validate().message(), testing::HasSubstr("local_tiles = 1"))
        << FormatTuning(tuning);
  }
  KernelTuning bad{.depth = 3};
  EXPECT_EQ(bad.Validate().message(), "depth = 3; it must be from 4 to 4096");
}

bool StartsWithAny(absl::string_view line, std::initializer_list<absl::string_view> prefixes) {
  for (const absl::string_view prefix : prefixes) {
    if (line.substr(0, prefix.size()) == prefix) return true;
  }
  return false;
}

// In C99 an inline function that is not static leaves a call that is not inlined to a definition
// elsewhere, which there is none of: compilers that do not inline refuse the program.
TEST(Sources, NoFunctionIsInlineAlone) {
  int functions = 0;
  for (const char* file :
       {"common.cl", "covariance.cl", "covariance_gradient.cl", "dense_posterior.cl",
        "dense_posterior_local.cl", "linear_algebra.cl", "posterior_outputs.cl", "roofline.cl"}) {
    const std::string text(cl_sources::Text(file));
    ASSERT_FALSE(text.empty()) << file;
    for (const absl::string_view line : absl::StrSplit(text, '\n')) {
      // Declarations of functions start at the margin; so does what follows, which is none.
      if (line.find('(') == std::string::npos ||
          StartsWithAny(line, {" ", "#", "/", "}", "__kernel", "typedef"})) {
        continue;
      }
      ++functions;
      EXPECT_FALSE(StartsWithAny(line, {"inline"})) << file << ": " << line;
    }
  }
  EXPECT_GT(functions, 20);
}

}  // namespace
}  // namespace egosieve::kernels
