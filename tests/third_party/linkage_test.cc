#include <CL/opencl.hpp>
#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <nanoflann.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/video/tracking.hpp>
#include <opencv2/videoio.hpp>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_format.h"
#include "gtest/gtest.h"

namespace {

TEST(Linkage, EveryLibraryOfTheBuildLinks) {
  EXPECT_EQ(absl::StrFormat("%d", 7), "7");
  absl::flat_hash_map<int, int> map = {{1, 2}};
  EXPECT_EQ(map[1], 2);
  EXPECT_FALSE(absl::StatusOr<int>(absl::NotFoundError("none")).ok());
  EXPECT_EQ(Eigen::MatrixXd::Identity(3, 3).llt().matrixL().determinant(), 1.0);
  EXPECT_FALSE(cv::SIFT::create().empty());
  EXPECT_FALSE(cv::DISOpticalFlow::create().empty());
  EXPECT_FALSE(cv::VideoCapture().isOpened());
  EXPECT_EQ(nlohmann::json::parse("[1]").size(), 1u);
  std::vector<cl::Platform> platforms;
  cl::Platform::get(&platforms);
  EXPECT_FALSE(platforms.empty()) << "no OpenCL platform: install pocl-opencl-icd";
}

}  // namespace
