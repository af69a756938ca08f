#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "kernels/files/atomic_file.h"
#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tools/segment/drive_writer.h"
#include "tools/segment/lens_file.h"
#include "tools/segment/run_camera.h"
#include "tools/segment/trajectory_file.h"

namespace egosieve::tools {
namespace {

using Outcome = FrameLine::Outcome;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
std::string Written(const std::string& name, const std::string& text) {
  const std::string path = std::string(std::getenv("TEST_TMPDIR")) + "/" + name;
  std::ofstream(path) << text;
  return path;
}

TEST(LensFile, ColmapsCameras) {
  const std::string text =
      "# Camera list with one line of data per camera:\n"
      "# Number of cameras: 1\n"
      "1 OPENCV 1920 1080 1500.0 1540.0 960 540 0.01 0 0 0\n";
  EXPECT_DOUBLE_EQ(LensOfColmap(text)->focal_ratio(), 1520.0 / 1920.0);
  EXPECT_FALSE(LensOfColmap(text)->is_pinhole());
  EXPECT_DOUBLE_EQ(LensOfColmap("1 SIMPLE_RADIAL 600 800 400 300 400 0.1")->focal_ratio(), 0.5);
  EXPECT_TRUE(LensOfColmap("1 SIMPLE_PINHOLE 600 800 400 300 400")->is_pinhole());
  const LensFile file = Value(ReadLensFile(Written("cameras.txt", text)));
  EXPECT_EQ(file.size, cv::Size(1920, 1080));
  EXPECT_EQ(file.lens.cx, 960.0);
  EXPECT_EQ(file.lens.distortion[0], 0.01);
}

// OpenCV's pixels have their centres at whole numbers.
void ExpectLens(const LensFile& file, std::vector<double> focals_and_centre,
                std::vector<double> distortion) {
  const vision::Lens& lens = file.lens;
  EXPECT_THAT((std::vector{lens.fx, lens.fy, lens.cx - 0.5, lens.cy - 0.5}),
              testing::Pointwise(testing::DoubleNear(1e-9), focals_and_centre));
  distortion.resize(lens.distortion.size());
  EXPECT_THAT(lens.distortion, testing::ElementsAreArray(distortion));
}

TEST(LensFile, CameraInfoOfRos) {
  const std::string text =
      "image_width: 640\nimage_height: 480\ncamera_name: narrow_stereo\n"
      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [438.7, 0, 305.5, 0, 437.3, 243.75, 0, 0, 1]\n"
      "distortion_model: plumb_bob\n"
      "distortion_coefficients:\n  rows: 1\n  cols: 5\n"
      "  data: [-0.36, 0.11, 0.001, 0.0005, 0.02]\n";
  const LensFile file = Value(ReadLensFile(Written("ost.yaml", text)));
  EXPECT_EQ(file.size, cv::Size(640, 480));
  ExpectLens(file, {438.7, 437.3, 305.5, 243.75}, {-0.36, 0.11, 0.001, 0.0005, 0.02});
  EXPECT_FALSE(file.lens.is_fisheye);
}

TEST(LensFile, CalibrationOfOpenCv) {
  const std::string text =
      "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n"
      "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
      "   data: [ 6.5e+02, 0., 319.5, 0., 6.6e+02, 239.5, 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
      "   data: [ -0.25, 0.1, 0., 0., 0.01 ]\n";
  ExpectLens(Value(ReadLensFile(Written("out_camera_data.yml", text))), {650, 660, 319.5, 239.5},
             {-0.25, 0.1, 0.0, 0.0, 0.01});
}

TEST(LensFile, CamchainOfKalibr) {
  const std::string text =
      "cam0:\n  T_cam_imu:\n  - [0.0, 1.0, 0.0, 0.1]\n  - [1.0, 0.0, 0.0, 0.2]\n"
      "  camera_model: pinhole\n  distortion_coeffs: [-0.27, 0.06, 0.0008, 0.0001]\n"
      "  distortion_model: equi\n  intrinsics: [461.6, 460.1, 362.5, 246.25]\n"
      "  resolution: [752, 480]\ncam1:\n  camera_model: omni\n";
  const LensFile file = Value(ReadLensFile(Written("camchain.yaml", text)));
  EXPECT_EQ(file.size, cv::Size(752, 480));
  ExpectLens(file, {461.6, 460.1, 362.5, 246.25}, {-0.27, 0.06, 0.0008, 0.0001});
  EXPECT_TRUE(file.lens.is_fisheye);
}

TEST(LensFile, JsonThereAndBack) {
  for (const char* text :
       {R"({"width": 640, "height": 360, "focal_pixels": 400})",
        R"({"width": 640, "height": 360, "fx": 400, "fy": 410, "cx": 300, "cy": 180, "k1": -0.2,
            "p1": 0.01, "k3": 0.1})",
        R"({"width": 640, "height": 360, "fx": 400, "fy": 410, "fisheye": true, "k3": 0.1})"}) {
    const LensFile file = Value(LensOfJson(text));
    const LensFile again = Value(LensOfJson(JsonOfLens(file).dump()));
    EXPECT_EQ(again.size, file.size);
    EXPECT_EQ(again.is_pinhole(), file.is_pinhole());
    EXPECT_EQ(again.lens.is_fisheye, file.lens.is_fisheye);
    ExpectLens(again, {file.lens.fx, file.lens.fy, file.lens.cx - 0.5, file.lens.cy - 0.5},
               {file.lens.distortion.begin(), file.lens.distortion.end()});
  }
  EXPECT_EQ(
      LensOfJson(R"({"width": 9, "height": 9, "fx": 4, "fy": 4, "k3": 2})")->lens.distortion[4],
      2.0);
  EXPECT_EQ(LensOfJson(R"({"width": 9, "height": 9, "fx": 4, "fy": 4, "k3": 2, "fisheye": true})")
                ->lens.distortion[2],
            2.0);
}

TEST(LensFile, OfPicturesOfAnotherSize) {
  LensFile file = Value(LensOfColmap("1 PINHOLE 1920 1080 1500 1540 960 500"));
  ASSERT_TRUE(ScaleTo({960, 540}, file).ok());
  ExpectLens(file, {750.0, 770.0, 479.5, 249.5}, {});
  EXPECT_THAT(ScaleTo({540, 960}, file).message(), testing::HasSubstr("another shape"));
}

TEST(LensFile, ARunsCamera) {
  const std::string path =
      Written("camera.json", R"({"focal_pixels": 720, "width": 1440, "height": 400})");
  EXPECT_DOUBLE_EQ(ReadLensFile(path)->focal_ratio(), 0.5);
}

TEST(LensFile, WhatIsWrongIsNamed) {
  const auto message = [](const std::string& text) {
    return std::string(LensOfColmap(text).status().message());
  };
  EXPECT_THAT(message("# nothing\n"), testing::HasSubstr("no camera"));
  EXPECT_THAT(message("1 MAGIC 10 10 5"), testing::HasSubstr("MAGIC is not known"));
  EXPECT_THAT(message("1 PINHOLE 10 10 5"), testing::HasSubstr("a number is missing"));
  EXPECT_THAT(message("1 PINHOLE 10 10 5 -4 5 5"), testing::HasSubstr("not positive"));
  EXPECT_THAT(message("1 PINHOLE ten 10 5 4 5 5"), testing::HasSubstr("'ten' is no such number"));
  EXPECT_THAT(message("1 EQUIRECTANGULAR 10 5 10 5"),
              testing::HasSubstr("EQUIRECTANGULAR cannot be undone"));
  const auto yaml = [](const std::string& text) {
    return std::string(LensOfYaml(text).status().message());
  };
  EXPECT_THAT(yaml("a: [1"), testing::HasSubstr("line"));
  EXPECT_THAT(yaml("a: 1"), testing::HasSubstr("neither camera_matrix"));
  EXPECT_THAT(yaml("cam0:\n  camera_model: omni\n"), testing::HasSubstr("the camera is omni-none"));
  EXPECT_THAT(
      LensOfJson(R"({"width": 9, "height": 9, "focal_pixels": 4, "k1": null})").status().message(),
      testing::HasSubstr("all coefficients numbers"));
  const std::string path = Written("bad.json", R"({"width": 1440})");
  EXPECT_THAT(ReadLensFile(path).status().message(), testing::HasSubstr("bad.json"));
  EXPECT_EQ(ReadLensFile(path + ".gone").status().code(), absl::StatusCode::kNotFound);
}

bool AreEqual(const cv::Mat1b& a, const cv::Mat1b& b) {
  return a.size() == b.size() && (a.empty() || cv::norm(a, b, cv::NORM_INF) == 0.0);
}

// What a resumed run reads is what the first one had.
TEST(RunCamera, IsReadAsWritten) {
  const std::string folder = FreshFolder();
  RunCamera camera;
  camera.text =
      R"({"focal_pixels": 50.0, "width": 64, "height": 48, "log_focal_deviation": 0.1, "pairs": 3,)"
      R"( "own_vehicle_share": 0.5, "fixed_pattern": true, "windscreen": true})";
  camera.own_vehicle = cv::Mat1b::zeros(48, 64);
  camera.own_vehicle(cv::Rect(0, 24, 64, 24)) = 255;
  camera.windscreen = cv::Mat1b::zeros(48, 64);
  camera.windscreen(cv::Rect(10, 10, 5, 7)) = 255;
  camera.fixed_pattern = cv::Mat1b(48, 64, 77);
  RunCameras cameras;
  cameras.end = 300;
  cameras.shots[0].text = R"({"focal_pixels": 80.0, "width": 64, "height": 48})";
  cameras.shots[120] = camera;
  ASSERT_TRUE(WriteRunCameras(folder, cameras).ok());
  const RunCameras read = Value(ReadRunCameras(folder));
  EXPECT_EQ(read.end, 300);
  ASSERT_THAT(read.shots, testing::SizeIs(2));
  EXPECT_TRUE(read.shots.at(0).own_vehicle.empty());
  EXPECT_DOUBLE_EQ(read.shots.at(0).lens.focal_ratio(), 80.0 / 64.0);
  const RunCamera& later = read.shots.at(120);
  EXPECT_TRUE(AreEqual(later.own_vehicle, camera.own_vehicle));
  EXPECT_TRUE(AreEqual(later.windscreen, camera.windscreen));
  EXPECT_TRUE(AreEqual(later.fixed_pattern, camera.fixed_pattern));
  EXPECT_DOUBLE_EQ(later.lens.focal_ratio(), 50.0 / 64.0);
}

// Each frame has the own vehicle of its shot.
TEST(RunCamera, TheIgnoredAreaIsThatOfTheShot) {
  const std::string path = FreshFolder();
  const RunFolder folder = Value(RunFolder::Create(path, false));
  const std::string text =
      R"({"focal_pixels": 50.0, "width": 4, "height": 2, "own_vehicle_share": 0.5})";
  RunCameras cameras;
  cameras.shots[0].text = cameras.shots[10].text = cameras.shots[20].text = text;
  cameras.shots[0].own_vehicle = cv::Mat1b::zeros(2, 4);
  cameras.shots[0].own_vehicle.row(1) = 255;
  cameras.shots[20].own_vehicle = cv::Mat1b::zeros(2, 4);
  cameras.shots[20].own_vehicle.row(0) = 255;
  ASSERT_TRUE(WriteRunCameras(path, cameras).ok());
  const IgnoredAreas areas = Value(folder.ReadIgnoredAreas());
  const auto at = [&](int64_t index) {
    return areas.In({.index = index, .width_pixels = 4, .height_pixels = 2});
  };
  EXPECT_TRUE(AreEqual(at(9), cameras.shots[0].own_vehicle));
  EXPECT_EQ(cv::countNonZero(at(10)), 0);
  EXPECT_EQ(cv::countNonZero(at(19)), 0);
  EXPECT_TRUE(AreEqual(at(20), cameras.shots[20].own_vehicle));
  EXPECT_TRUE(AreEqual(at(500), cameras.shots[20].own_vehicle));
}

TEST(RunCamera, ALackingWindscreenIsAnError) {
  const std::string folder = FreshFolder();
  RunCameras cameras;
  cameras.shots[0].text =
      R"({"focal_pixels": 50.0, "width": 64, "height": 48, "windscreen": true})";
  ASSERT_TRUE(WriteRunCameras(folder, cameras).ok());
  EXPECT_FALSE(ReadRunCameras(folder).ok());
}

TEST(RunCamera, AFolderWithoutOneHasNone) {
  EXPECT_TRUE(Value(ReadRunCameras(FreshFolder())).shots.empty());
}

// `learnt` frames, and then others that are answered for the reason, with doubt or without.
RunVerdict Judge(int learnt, int answered, const std::string& reason, const std::string& doubt) {
  DriveWriter::Counts counts((RunDescription()));
  for (int i = 0; i < learnt + answered; ++i) {
    FrameLine line{.index = i, .outcome = i < learnt ? Outcome::kLearnt : Outcome::kAnswered};
    if (i >= learnt) {
      line.reason = reason;
      line.doubt = doubt;
    }
    counts.Add(line);
  }
  return JudgeRun(counts, "");
}

TEST(RunVerdict, ARunThatLearntFromNothingOrFewFramesIsNoSuccess) {
  const RunVerdict nothing = Judge(0, 9, "only 3 features", "only 3 features");
  EXPECT_EQ(nothing.code, ExitCode::kFramesFailed);
  EXPECT_THAT(nothing.warnings, ElementsAre(HasSubstr("nothing was learnt")));

  const RunVerdict few = Judge(4, 5, "only 3 features", "only 3 features");
  EXPECT_EQ(few.code, ExitCode::kFramesFailed);
  EXPECT_THAT(few.warnings, ElementsAre(HasSubstr("only 4 of 9 frames were learnt from")));

  const RunVerdict half = Judge(5, 5, "only 3 features", "only 3 features");
  EXPECT_EQ(half.code, ExitCode::kDone);
  EXPECT_THAT(half.warnings, IsEmpty());
}

// The same picture again, as where a camera's pictures were doubled.
TEST(RunVerdict, RepeatedPicturesDoNotCount) {
  EXPECT_EQ(Judge(4, 20, "the same picture as the frame before", "").code, ExitCode::kDone);
  EXPECT_EQ(Judge(0, 20, "the same picture as the frame before", "").code, ExitCode::kFramesFailed);
}

TEST(RunVerdict, AnInputThatEndsTooEarlyIsNoSuccess) {
  const RunVerdict verdict = JudgeRun(DriveWriter::Counts((RunDescription())), "a.mp4: cut short");
  EXPECT_EQ(verdict.code, ExitCode::kFramesFailed);
  EXPECT_THAT(verdict.warnings, ElementsAre("a.mp4: cut short"));
}

// Rows of seconds, centre and quaternion (x, y, z, w); lines with # are comments.
std::vector<std::array<double, 8>> Poses(const std::string& text) {
  std::vector<std::array<double, 8>> poses;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream numbers(line);
    for (double& number : poses.emplace_back()) numbers >> number;
    EXPECT_FALSE(numbers.fail()) << line;
  }
  return poses;
}

TEST(TrajectoryFile, PosesAreReadAgainAsTheyAre) {
  std::vector<FrameLine> lines(11);
  for (int k = 0; k < 11; ++k) {
    lines[k].index = k;
    lines[k].time_seconds = 0.1 * k;
    if (k == 0) continue;
    lines[k].step.known = true;
    lines[k].step.rotation = Eigen::Vector3d(0.0, 0.05, 0.0);
    lines[k].step.direction = Eigen::Vector3d(0.0, 0.0, -1.0);
    lines[k].step.heights = 2.0;
  }
  const auto poses = Poses(TrajectoryText(lines));
  ASSERT_EQ(poses.size(), 11u);
  EXPECT_DOUBLE_EQ(poses[10][0], 1.0);
  const auto centre = [&](int k) { return Eigen::Vector3d(poses[k][1], poses[k][2], poses[k][3]); };
  EXPECT_EQ(centre(0).norm(), 0.0);
  const Eigen::AngleAxisd turn(
      Eigen::Quaterniond(poses[10][7], poses[10][4], poses[10][5], poses[10][6]).normalized());
  EXPECT_NEAR(turn.angle(), 0.5, 1e-6);
  EXPECT_NEAR(turn.axis()(1), -1.0, 1e-6);  // the camera turns the other way than its picture
  // Chords of 2 on a circle: 10 sides that turn by 0.05 each.
  EXPECT_NEAR(centre(10).norm(), 2.0 * std::sin(0.25) / std::sin(0.025), 1e-4);
}

TEST(TrajectoryFile, WithoutStepsThereIsNone) {
  EXPECT_EQ(TrajectoryText(std::vector<FrameLine>(3)), "");
}

}  // namespace
}  // namespace egosieve::tools
