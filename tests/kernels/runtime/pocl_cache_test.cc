#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <string>

#include "absl/strings/match.h"
#include "kernels/files/atomic_file.h"
#include "kernels/runtime/device.h"
#include "kernels/runtime/driver_check.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

class WithoutAHome : public testing::Test {
 protected:
  WithoutAHome() {
    unsetenv("POCL_CACHE_DIR");
    unsetenv("XDG_CACHE_HOME");
    setenv("HOME", "/dev/null/home", 1);  // nobody can make it, root neither
    setenv("TMPDIR", testing::TempDir().c_str(), 1);
  }
};

// The environment is the program's, and other threads may be reading it.
TEST_F(WithoutAHome, TheLibraryLeavesTheEnvironmentAlone) {
  EXPECT_FALSE(CheckPoclCanWrite().ok());
  ASSERT_TRUE(ListDevices().ok());
  EXPECT_EQ(std::getenv("POCL_CACHE_DIR"), nullptr);
}

TEST_F(WithoutAHome, AProgramGivesPoclAFolder) {
  LetPoclWrite();
  const char* folder = std::getenv("POCL_CACHE_DIR");
  ASSERT_NE(folder, nullptr);
  EXPECT_EQ(std::string(folder).rfind(testing::TempDir(), 0), 0u) << folder;
  EXPECT_TRUE(CheckPoclCanWrite().ok());
  setenv("POCL_CACHE_DIR", "/dev/null/own", 1);
  LetPoclWrite();
  EXPECT_STREQ(std::getenv("POCL_CACHE_DIR"), "/dev/null/own");
  EXPECT_FALSE(CheckPoclCanWrite().ok());
}

// A limit on the size of files stands for a full disk.
TEST(PoclCache, AFullDiskIsNamedWhereAProgramCannotBeBuilt) {
  const std::string folder = testing::TempDir() + "/full";
  ASSERT_TRUE(CreateFolder(folder).ok());
  setenv("POCL_CACHE_DIR", folder.c_str(), 1);
  const auto context = Value(OpenContext());
  if (!absl::StrContains(context->info().platform, "Portable")) GTEST_SKIP() << "not PoCL";
  signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit little{1000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &little), 0);
  const absl::Status status =
      context
          ->Kernel("linear_algebra.cl",
                   "-cl-std=CL1.2 -DREAL_IS_DOUBLE -DVEC=1 -DTILE=64 -DITEM=4 -DDEPTH=16",
                   "get_diagonal")
          .status();
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(std::string(status.message()),
              testing::AllOf(testing::StartsWith("cannot write " + folder),
                             testing::HasSubstr("POCL_CACHE_DIR")));
}

}  // namespace
}  // namespace egosieve::kernels
