// Against OpenCV's maps of undistortion, which are made by other code from the same coefficients.
#include "tools/colmap/lens.h"

#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "tests/testing/status.h"

namespace egosieve::tools {
namespace {

SparseCamera CameraOf(const std::string& model, std::vector<double> parameters) {
  SparseCamera camera;
  while (FindCameraModel(camera.model)->name != model) ++camera.model;
  camera.width = 96;
  camera.height = 64;
  camera.parameters = std::move(parameters);
  EXPECT_EQ(camera.parameters.size(), FindCameraModel(camera.model)->parameters);
  return camera;
}

// OpenCV's maps are in float32, of which the last bit of 100 pixels is 8e-6.
void ExpectAsOpenCv(const vision::Lens& lens, const cv::Mat& coefficients) {
  const cv::Size size(110, 70);
  const cv::Matx33d original(lens.fx, 0.0, lens.cx - 0.5, 0.0, lens.fy, lens.cy - 0.5, 0.0, 0.0,
                             1.0);
  const cv::Matx33d undistorted(55.0, 0.0, 53.0, 0.0, 57.0, 36.0, 0.0, 0.0, 1.0);
  cv::Mat1f map_x, map_y;
  if (lens.is_fisheye) {
    cv::fisheye::initUndistortRectifyMap(original, coefficients, cv::Matx33d::eye(), undistorted,
                                         size, CV_32FC1, map_x, map_y);
  } else {
    cv::initUndistortRectifyMap(original, coefficients, cv::noArray(), undistorted, size, CV_32FC1,
                                map_x, map_y);
  }
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const auto [at_x, at_y] = lens.Project((x - 53.0) / 55.0, (y - 36.0) / 57.0);
      ASSERT_NEAR(at_x - 0.5, map_x(y, x), 1e-4) << x << ", " << y;
      ASSERT_NEAR(at_y - 0.5, map_y(y, x), 1e-4) << x << ", " << y;
    }
  }
}

struct Case {
  const char* model;
  std::vector<double> parameters, coefficients;
};

void ExpectAsOpenCv(const std::vector<Case>& cases, bool is_fisheye) {
  for (const Case& each : cases) {
    SCOPED_TRACE(each.model);
    const vision::Lens lens = Value(LensOf(CameraOf(each.model, each.parameters)));
    EXPECT_EQ(lens.is_fisheye, is_fisheye);
    EXPECT_EQ(lens.is_pinhole(), !is_fisheye && each.coefficients[0] == 0.0);
    ExpectAsOpenCv(lens, cv::Mat(each.coefficients, true));
  }
}

TEST(ColmapLens, MapsPerspectiveModelsAsOpenCvDoes) {
  const std::vector<Case> cases = {
      {"SIMPLE_PINHOLE", {60, 48, 32}, {0, 0, 0, 0}},
      {"PINHOLE", {60, 65, 49, 31}, {0, 0, 0, 0}},
      {"SIMPLE_RADIAL", {60, 48, 32, -0.2}, {-0.2, 0, 0, 0}},
      {"RADIAL", {60, 48, 32, -0.2, 0.05}, {-0.2, 0.05, 0, 0}},
      {"OPENCV", {60, 65, 49, 31, -0.2, 0.05, 0.01, -0.02}, {-0.2, 0.05, 0.01, -0.02}},
      {"FULL_OPENCV",
       {60, 65, 49, 31, -0.2, 0.05, 0.01, -0.02, 0.03, 0.1, 0.04, 0.02},
       {-0.2, 0.05, 0.01, -0.02, 0.03, 0.1, 0.04, 0.02}}};
  ExpectAsOpenCv(cases, /*is_fisheye=*/false);
}

TEST(ColmapLens, MapsFisheyesAsOpenCvDoes) {
  const std::vector<Case> cases = {
      {"SIMPLE_FISHEYE", {60, 48, 32}, {0, 0, 0, 0}},
      {"FISHEYE", {60, 65, 49, 31}, {0, 0, 0, 0}},
      {"SIMPLE_RADIAL_FISHEYE", {60, 48, 32, -0.1}, {-0.1, 0, 0, 0}},
      {"RADIAL_FISHEYE", {60, 48, 32, -0.1, 0.04}, {-0.1, 0.04, 0, 0}},
      {"OPENCV_FISHEYE", {60, 65, 49, 31, -0.1, 0.04, 0.02, -0.03}, {-0.1, 0.04, 0.02, -0.03}}};
  ExpectAsOpenCv(cases, /*is_fisheye=*/true);
}

TEST(ColmapLens, RefusesWhatItCannotMap) {
  EXPECT_THAT(LensOf(CameraOf("FOV", {60, 60, 48, 32, 0.9})), IsInvalid("FOV cannot"));
  EXPECT_THAT(LensOf(CameraOf("EQUIRECTANGULAR", {96, 64})), IsInvalid("EQUIRECTANGULAR cannot"));
  EXPECT_THAT(LensOf(CameraOf("SIMPLE_PINHOLE", {0, 48, 32})), IsInvalid("not positive"));
}

}  // namespace
}  // namespace egosieve::tools
