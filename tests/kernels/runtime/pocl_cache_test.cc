#include "kernels/runtime/pocl_cache.h"

#include <cstdlib>
#include <string>

#include "gtest/gtest.h"
#include "kernels/runtime/device.h"

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
  EXPECT_FALSE(PoclCanWrite());
  ASSERT_TRUE(ListDevices().ok());
  EXPECT_EQ(std::getenv("POCL_CACHE_DIR"), nullptr);
}

TEST_F(WithoutAHome, AProgramGivesPoclAFolder) {
  LetPoclWrite();
  const char* folder = std::getenv("POCL_CACHE_DIR");
  ASSERT_NE(folder, nullptr);
  EXPECT_EQ(std::string(folder).rfind(testing::TempDir(), 0), 0u) << folder;
  EXPECT_TRUE(PoclCanWrite());
  setenv("POCL_CACHE_DIR", "/dev/null/own", 1);
  LetPoclWrite();
  EXPECT_STREQ(std::getenv("POCL_CACHE_DIR"), "/dev/null/own");
  EXPECT_FALSE(PoclCanWrite());
}

}  // namespace
}  // namespace egosieve::kernels
