// A test with an empty folder of its own.
#ifndef EGOSIEVE_TESTS_VISION_FRAME_FOLDER_TEST_H_
#define EGOSIEVE_TESTS_VISION_FRAME_FOLDER_TEST_H_

#include <filesystem>
#include <fstream>
#include <string>

#include "gtest/gtest.h"
#include "vision/frame/quiet_libraries.h"

namespace egosieve::vision {

class FolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    QuietLibraries();
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  void WriteText(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name), std::ios::binary) << text;
  }

  std::filesystem::path folder_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_TESTS_VISION_FRAME_FOLDER_TEST_H_
