// A folder for each test of `egosieve masks`, and pictures compared pixel by pixel.
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/testing/fresh_folder.h"
#include "tests/tools/testing/fake_run.h"
#include "tests/tools/testing/run_command.h"
#include "tools/cli/command.h"

namespace egosieve::tools {

class MasksTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = FreshFolder();
    out_ = root_ + "/out";
  }

  CommandOutcome Masks(std::vector<std::string> arguments) const {
    arguments.push_back("--out=" + out_);
    arguments.push_back("--progress=none");
    return RunCommandForTest(MakeMasksCommand(), std::move(arguments));
  }

  cv::Mat Read(const std::string& name) const {
    return cv::imread(out_ + "/" + name, cv::IMREAD_UNCHANGED);
  }

  static cv::Mat Made(const FakeRun& run, const char* folder, int index) {
    return cv::imread(run.folder.FrameFile(folder, index, ".png"), cv::IMREAD_UNCHANGED);
  }

  std::string root_, out_;
};

inline int Differences(const cv::Mat& a, const cv::Mat& b) {
  EXPECT_EQ(a.size(), b.size());
  EXPECT_EQ(a.type(), b.type());
  return cv::countNonZero(a != b);
}

}  // namespace egosieve::tools
