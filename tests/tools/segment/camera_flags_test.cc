#include "tools/segment/camera_flags.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "tools/segment/run_camera.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::tools {
namespace {

// The labeller's options of a run that is continued, whose camera is `camera`.
vision::FrameLabellerOptions Continued(const RunCamera& camera,
                                       vision::FrameLabellerOptions labeller = {}) {
  const std::string folder = testing::TempDir() + "/camera_flags";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  EXPECT_TRUE(WriteRunCamera(folder, camera).ok());
  labeller.motion_model = vision::MotionModelChoice::kCalibrated;
  CameraFlags flags;
  EXPECT_TRUE(flags.Find(DriveInput(), 0, true, folder, labeller).ok());
  return labeller;
}

RunCamera WithPattern(bool has_pattern) {
  RunCamera camera;
  camera.text = R"({"focal_pixels": 50.0, "width": 64, "height": 48, "fixed_pattern": )";
  camera.text += has_pattern ? "true}" : "false}";
  if (has_pattern) camera.fixed_pattern = cv::Mat1b(48, 64, 77);
  return camera;
}

TEST(CameraFlags, TheFirstPassAloneFindsTheOwnVehicleWhereItSawTheDrive) {
  const vision::FrameLabellerOptions seen = Continued(WithPattern(true));
  EXPECT_FALSE(seen.evidence.own_vehicle);
  EXPECT_TRUE(seen.evidence.road);
  EXPECT_DOUBLE_EQ(seen.focal_ratio, 50.0 / 64.0);
  EXPECT_TRUE(Continued(WithPattern(false)).evidence.own_vehicle) << "too few pictures";
}

TEST(CameraFlags, TermsThatWereAskedForStayMoreThanTheEpipolarOne) {
  vision::FrameLabellerOptions labeller;
  labeller.evidence = vision::EvidenceTerms::EpipolarAlone();
  labeller.evidence.own_vehicle = true;
  EXPECT_TRUE(Continued(WithPattern(true), labeller).IsCalibrated());
}

}  // namespace
}  // namespace egosieve::tools
