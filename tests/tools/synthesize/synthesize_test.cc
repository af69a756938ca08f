#include "tools/synthesize/synthesize.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>

#include "tests/testing/status.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

class SynthesizeTest : public ::testing::Test {
 protected:
  SynthesizeTest() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / test->name();
    fs::remove_all(folder_);
    options_.output_folder = (folder_ / "drive").string();
    options_.scenario = "crossing";
    options_.rendering.width_pixels = 96;
    options_.rendering.height_pixels = 54;
    options_.rendering.frames = 3;
  }

  fs::path File(const std::string& name) const { return fs::path(options_.output_folder) / name; }
  static std::string Bytes(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  fs::path folder_;
  SynthesizeOptions options_;
};

TEST_F(SynthesizeTest, FolderHoldsFramesMasksIdsAndAConsistentScene) {
  int calls = 0;
  ASSERT_TRUE(Synthesize(options_, [&](int done, int total) {
                EXPECT_EQ(done, ++calls);
                return total == 3;
              }).ok());
  EXPECT_EQ(calls, 3);
  const auto scene = nlohmann::json::parse(Bytes(File("scene.json")));
  EXPECT_EQ(scene.at("scenario"), "crossing");
  EXPECT_EQ(scene.at("width"), 96);
  ASSERT_EQ(scene.at("frames").size(), 3u);
  for (int k = 0; k < 3; ++k) {
    const std::string name = "00000" + std::to_string(k) + ".png";
    const cv::Mat image = cv::imread(File("frames/" + name).string(), cv::IMREAD_UNCHANGED);
    const cv::Mat mask = cv::imread(File("masks/" + name).string(), cv::IMREAD_UNCHANGED);
    const cv::Mat ids = cv::imread(File("ids/" + name).string(), cv::IMREAD_UNCHANGED);
    EXPECT_EQ(image.type(), CV_8UC3);
    EXPECT_EQ(image.size(), cv::Size(96, 54));
    ASSERT_EQ(mask.type(), CV_8UC1);
    ASSERT_EQ(ids.type(), CV_16UC1);
    // The objects' areas are those of ids/, and masks/ shows exactly the moving ones.
    int moving_pixels = 0;
    for (const auto& object : scene["frames"][k]["objects"]) {
      const cv::Mat pixels = ids == object.at("id").get<int>();
      EXPECT_EQ(cv::countNonZero(pixels), object.at("area_pixels").get<int>());
      if (object.at("moving")) {
        moving_pixels += cv::countNonZero(pixels);
        EXPECT_EQ(cv::countNonZero(pixels & (mask != 255)), 0);
      }
    }
    EXPECT_EQ(cv::countNonZero(mask), moving_pixels);
    EXPECT_EQ(cv::countNonZero(mask == 255), moving_pixels);
  }
}

TEST_F(SynthesizeTest, SameOptionsSameBytes) {
  ASSERT_TRUE(Synthesize(options_).ok());
  const std::string image = Bytes(File("frames/000002.png")), scene = Bytes(File("scene.json"));
  options_.overwrite = true;
  options_.rendering.threads = 1;
  ASSERT_TRUE(Synthesize(options_).ok());
  EXPECT_EQ(Bytes(File("frames/000002.png")), image);
  EXPECT_EQ(Bytes(File("scene.json")), scene);
  options_.seed = 2;
  ASSERT_TRUE(Synthesize(options_).ok());
  EXPECT_NE(Bytes(File("frames/000002.png")), image);
}

TEST_F(SynthesizeTest, PosesAndCameraAreThoseOfTheScene) {
  options_.rendering.radial = -0.1;
  options_.rendering.frames_per_second = 15.0;
  ASSERT_TRUE(Synthesize(options_).ok());
  const auto scene = nlohmann::json::parse(Bytes(File("scene.json")));
  const auto camera = nlohmann::json::parse(Bytes(File("camera.json")));
  EXPECT_EQ(camera.at("focal_pixels"), scene.at("intrinsics").at("focal_pixels"));
  EXPECT_EQ(camera.at("k1"), -0.1);
  EXPECT_EQ(camera.at("width"), 96);
  EXPECT_EQ(camera.at("frames_per_second"), 15.0);
  std::ifstream poses(File("poses.txt"));
  for (const auto& frame : scene.at("frames")) {
    for (int k = 0; k < 12; ++k) {
      double value = 0.0;
      ASSERT_TRUE(poses >> value);
      EXPECT_EQ(value, frame.at("world_from_camera")[k / 4][k % 4].get<double>());
    }
  }
  double value;
  EXPECT_FALSE(poses >> value);
  EXPECT_FALSE(fs::exists(File("own_vehicle.png")));
}

TEST_F(SynthesizeTest, TheDashcamsOwnVehicleIsVoidInItsMasks) {
  options_.scenario = "dashcam";
  ASSERT_TRUE(Synthesize(options_).ok());
  const cv::Mat own = cv::imread(File("own_vehicle.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Mat mask = cv::imread(File("masks/000002.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(own.type(), CV_8UC1);
  EXPECT_GT(cv::countNonZero(own), 0);
  EXPECT_EQ(cv::countNonZero((mask == 128) != own), 0);
}

// A codec leaves artefacts: the pictures differ from the clean ones, by a few grey levels.
TEST_F(SynthesizeTest, CompressedFramesKeepTheSceneAndGetArtefacts) {
  options_.rendering.width_pixels = 192;
  options_.rendering.height_pixels = 108;
  ASSERT_TRUE(Synthesize(options_).ok());
  const cv::Mat clean = cv::imread(File("frames/000001.png").string());
  const std::string mask = Bytes(File("masks/000001.png"));
  options_.overwrite = true;
  for (const Compression compression : {Compression::kJpeg, Compression::kH264}) {
    options_.compression = compression;
    const absl::Status status = Synthesize(options_);
    if (status.code() == absl::StatusCode::kUnavailable) GTEST_SKIP() << status;
    ASSERT_TRUE(status.ok()) << status;
    const cv::Mat coded = cv::imread(File("frames/000001.png").string());
    ASSERT_EQ(coded.size(), clean.size());
    const double difference = cv::norm(clean, coded, cv::NORM_L1) / (3.0 * clean.total());
    EXPECT_GT(difference, 0.5);
    EXPECT_LT(difference, 12.0);
    EXPECT_EQ(Bytes(File("masks/000001.png")), mask);
    EXPECT_FALSE(fs::exists(File("coded.mp4")));
  }
}

TEST_F(SynthesizeTest, VideoHasEveryFrame) {
  options_.video = true;
  ASSERT_TRUE(Synthesize(options_).ok());
  EXPECT_FALSE(fs::exists(File("frames")));
  cv::VideoCapture video(File("video.mp4").string());
  int frames = 0;
  for (cv::Mat frame; video.read(frame); ++frames) EXPECT_EQ(frame.size(), cv::Size(96, 54));
  EXPECT_EQ(frames, 3);
}

TEST_F(SynthesizeTest, ForeignFilesAreNeverTouched) {
  fs::create_directories(options_.output_folder);
  std::ofstream(File("thesis.tex")) << "x";
  options_.overwrite = true;
  EXPECT_THAT(Synthesize(options_), IsError(absl::StatusCode::kAlreadyExists, "thesis.tex"));
  EXPECT_EQ(Bytes(File("thesis.tex")), "x");
  EXPECT_FALSE(fs::exists(File("frames")));
}

TEST_F(SynthesizeTest, ForeignFilesInsideADriveKeepItWhole) {
  ASSERT_TRUE(Synthesize(options_).ok());
  std::ofstream(File("masks/notes.txt")) << "x";
  options_.overwrite = true;
  EXPECT_EQ(Synthesize(options_).code(), absl::StatusCode::kAlreadyExists);
  EXPECT_TRUE(fs::exists(File("frames/000002.png")));
}

TEST_F(SynthesizeTest, ADriveIsReplacedOnlyOnRequest) {
  ASSERT_TRUE(Synthesize(options_).ok());
  EXPECT_EQ(Synthesize(options_).code(), absl::StatusCode::kAlreadyExists);
  options_.overwrite = true;
  options_.rendering.frames = 2;
  ASSERT_TRUE(Synthesize(options_).ok());
  EXPECT_TRUE(fs::exists(File("frames/000001.png")));
  EXPECT_FALSE(fs::exists(File("frames/000002.png")));
}

TEST_F(SynthesizeTest, InterruptionLeavesNoScene) {
  const absl::Status status = Synthesize(options_, [](int done, int) { return done < 2; });
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
  EXPECT_TRUE(fs::exists(File("frames/000001.png")));
  EXPECT_FALSE(fs::exists(File("frames/000002.png")));
  EXPECT_FALSE(fs::exists(File("scene.json")));
  EXPECT_EQ(Synthesize(options_).code(), absl::StatusCode::kAlreadyExists);
  options_.overwrite = true;
  EXPECT_TRUE(Synthesize(options_).ok());
  EXPECT_FALSE(fs::exists(File("unfinished")));
}

// Frames and masks by number are what others' data look like, too.
TEST_F(SynthesizeTest, SomebodysFramesAreNoDrive) {
  for (const char* name : {"frames", "masks"}) {
    fs::create_directories(File(name));
    std::ofstream(File(name) / "000000.png") << "mine";
  }
  options_.overwrite = true;
  EXPECT_EQ(Synthesize(options_).code(), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(Bytes(File("frames/000000.png")), "mine");
}

TEST_F(SynthesizeTest, BadOptionsWriteNothing) {
  options_.scenario = "motorway";
  absl::Status status = Synthesize(options_);
  EXPECT_THAT(status, IsError(absl::StatusCode::kNotFound, "standing_traffic"));
  options_.scenario = "street";
  options_.rendering.frames = 0;
  status = Synthesize(options_);
  EXPECT_THAT(status, IsInvalid("frames = 0"));
  EXPECT_FALSE(fs::exists(folder_));
}

}  // namespace
}  // namespace egosieve::tools
