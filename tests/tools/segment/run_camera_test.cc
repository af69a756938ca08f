#include "tools/segment/run_camera.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "kernels/files/atomic_file.h"
#include "tests/testing/status.h"

namespace egosieve::tools {
namespace {

std::string Folder() {
  const std::string folder = testing::TempDir() + "/run_camera";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

bool AreEqual(const cv::Mat1b& a, const cv::Mat1b& b) {
  return a.size() == b.size() && (a.empty() || cv::norm(a, b, cv::NORM_INF) == 0.0);
}

// What a resumed run reads is what the first one had.
TEST(RunCamera, IsReadAsWritten) {
  const std::string folder = Folder();
  RunCamera camera;
  camera.text =
      R"({"focal_pixels": 50.0, "width": 64, "height": 48, "log_focal_deviation": 0.1, "pairs": 3,)"
      R"( "own_vehicle_share": 0.5, "fixed_pattern": true, "windscreen": true})";
  camera.own_vehicle = cv::Mat1b::zeros(48, 64);
  camera.own_vehicle(cv::Rect(0, 24, 64, 24)) = 255;
  camera.windscreen = cv::Mat1b::zeros(48, 64);
  camera.windscreen(cv::Rect(10, 10, 5, 7)) = 255;
  camera.fixed_pattern = cv::Mat1b(48, 64, 77);
  ASSERT_TRUE(WriteRunCamera(folder, camera).ok());
  const auto read = ReadRunCamera(folder);
  ASSERT_TRUE(read.ok() && read->has_value()) << read.status();
  EXPECT_TRUE(AreEqual((*read)->own_vehicle, camera.own_vehicle));
  EXPECT_TRUE(AreEqual((*read)->windscreen, camera.windscreen));
  EXPECT_TRUE(AreEqual((*read)->fixed_pattern, camera.fixed_pattern));
  EXPECT_DOUBLE_EQ((*read)->focal_ratio, 50.0 / 64.0);
}

TEST(RunCamera, ALackingWindscreenIsAnError) {
  const std::string folder = Folder();
  ASSERT_TRUE(kernels::WriteFileAtomically(
                  folder + "/camera.json",
                  R"({"focal_pixels": 50.0, "width": 64, "height": 48, "windscreen": true})")
                  .ok());
  EXPECT_FALSE(ReadRunCamera(folder).ok());
}

TEST(RunCamera, AFolderWithoutOneHasNone) {
  const auto read = Value(ReadRunCamera(Folder()));
  EXPECT_FALSE(read.has_value());
}

}  // namespace
}  // namespace egosieve::tools
