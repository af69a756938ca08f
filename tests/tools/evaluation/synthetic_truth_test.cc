#include "tools/evaluation/synthetic_truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tools/synthesize/synthesize.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class SyntheticTruthTest : public ::testing::Test {
 protected:
  SyntheticTruthTest() {
    folder_ = fs::path(::testing::TempDir()) /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    SynthesizeOptions options;
    options.scenario = "crossing";
    options.output_folder = folder_.string();
    options.rendering.width_pixels = 160;
    options.rendering.height_pixels = 90;
    options.rendering.frames = 5;
    options.rendering.frames_per_second = 2;
    EXPECT_TRUE(Synthesize(options).ok());
  }
  fs::path folder_;
};

TEST_F(SyntheticTruthTest, MovingIdsAreTheMasks) {
  EXPECT_TRUE(IsSyntheticTruth(folder_.string()));
  EXPECT_TRUE(IsSyntheticTruth((folder_ / "masks").string() + "/"));
  const SyntheticTruth truth = *ReadSyntheticTruth((folder_ / "masks").string());
  EXPECT_EQ(truth.width_pixels, 160);
  ASSERT_EQ(truth.frames.size(), 5u);
  int moving_pixels = 0;
  for (const int frame : {0, 2, 4}) {
    const cv::Mat1i ids = *truth.ReadMovingIds(frame);
    char name[32];
    std::snprintf(name, sizeof(name), "masks/%06d.png", frame);
    const cv::Mat1b mask = cv::imread((folder_ / name).string(), cv::IMREAD_UNCHANGED);
    EXPECT_EQ(cv::countNonZero((ids != 0) != (mask != 0)), 0);
    moving_pixels += cv::countNonZero(ids);
    for (const auto& [id, object] : truth.frames.at(frame)) {
      EXPECT_EQ(object.moving, object.relation != "standing");
      EXPECT_EQ(cv::countNonZero(ids == id), object.moving ? object.area_pixels : 0);
    }
  }
  EXPECT_GT(moving_pixels, 0);
  EXPECT_EQ(truth.ReadMovingIds(5).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(SyntheticTruthTest, DamageIsNamed) {
  const SyntheticTruth truth = *ReadSyntheticTruth(folder_.string());
  fs::remove(folder_ / "ids/000003.png");
  EXPECT_EQ(truth.ReadMovingIds(3).status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(truth.ReadMovingIds(3).status().message()), HasSubstr("000003.png"));
  std::ofstream(folder_ / "ids/000004.png") << "no picture";
  EXPECT_EQ(truth.ReadMovingIds(4).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(truth.ReadMovingIds(4).status().message()), HasSubstr("000004.png"));
  std::ofstream(folder_ / "scene.json") << "{\"width\": 160, \"height\": \"tall\", \"frames\": []}";
  const absl::Status status = ReadSyntheticTruth(folder_.string()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(status.message()), HasSubstr("height"));
  fs::remove(folder_ / "scene.json");
  EXPECT_FALSE(IsSyntheticTruth(folder_.string()));
  EXPECT_EQ(ReadSyntheticTruth(folder_.string()).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace egosieve::tools
