// A folder of the current test's own.
#pragma once

#include <filesystem>
#include <string>

#include "gtest/gtest.h"

namespace egosieve {

// Named after the test, empty: what it held before is gone.
inline std::string FreshFolder() {
  const std::string folder =
      testing::TempDir() + "/" + testing::UnitTest::GetInstance()->current_test_info()->name();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace egosieve
