#include "tools/evaluate/further_truth.h"

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fake_run.h"

namespace egosieve::tools {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

std::string Root() {
  return testing::TempDir() + "/" + testing::UnitTest::GetInstance()->current_test_info()->name();
}

void Write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

// In a picture of 96 x 64 a disc of radius 12 (p about 0.9) is centred at (12 + 7 index, 32); p is
// about 0.2 elsewhere. The prior's frame 0 has boxes, too.
TEST(FurtherTruth, BoxesBesideTheFramesAreScoredByTheMap) {
  const FakeRun run = WriteFakeRun(Root());
  std::string csv = "frame,id,type,x1,y1,x2,y2,truncated,occluded,depth,moving\n";
  for (int k = 0; k < 6; ++k) {
    const int x = 12 + 7 * k;
    absl::StrAppendFormat(&csv, "%d,0,Car,%d,20,%d,44,0,0,15,1\n", k, x - 12, x + 12);
    absl::StrAppendFormat(&csv, "%d,1,Cyclist,70,0,95,9,0,0,30,0\n", k);
  }
  Write(Root() + "/boxes.csv", csv);
  const FurtherTruth truth = FindFurtherTruth(run.frames);
  EXPECT_THAT(truth.boxes, EndsWith("/BoxesBesideTheFramesAreScoredByTheMap/boxes.csv"));
  EXPECT_EQ(truth.poses, "");
  const auto scores = ScoreFurther(run.folder, truth, {});
  ASSERT_TRUE(scores.ok()) << scores.status();
  ASSERT_TRUE(scores->boxes.has_value());
  EXPECT_EQ(scores->boxes->frames(), 5);
  EXPECT_EQ(scores->boxes->Of("moving vehicle", "10-20 m").marked, 5);
  EXPECT_EQ(scores->boxes->Of("standing cyclist", "all").boxes, 5);
  EXPECT_EQ(scores->boxes->Of("standing cyclist", "all").marked, 0);
  EXPECT_EQ(scores->boxes->OutsideShare(), 0.0);  // the box encloses the disc
  EXPECT_FALSE(scores->trajectory.has_value());
  EXPECT_THAT(ToTable(*scores), HasSubstr("5 of 5 1.00"));
  EXPECT_EQ(ToJson(*scores)["boxes"]["frames"], 5);
}

TEST(FurtherTruth, NothingIsScoredWhereNothingIsKnown) {
  const FakeRun run = WriteFakeRun(Root());
  const auto scores = ScoreFurther(run.folder, FindFurtherTruth(run.frames), {});
  ASSERT_TRUE(scores.ok()) << scores.status();
  EXPECT_TRUE(scores->empty());
  EXPECT_EQ(ToTable(*scores), "");
  FurtherTruth gone;
  gone.boxes = "/nowhere.csv";
  EXPECT_EQ(ScoreFurther(run.folder, gone, {}).status().code(), absl::StatusCode::kNotFound);
}

// Frames of the fake run are 1/25 s apart. The estimate turns by 1 degree a frame about y where the
// truth turns by 0.5: at 5 rows a second that is an error of 2.5 degrees a second.
TEST(FurtherTruth, TheRunsTrajectoryAndLensAreComparedWithTheTruth) {
  const FakeRun run = WriteFakeRun(Root());
  std::string poses, trajectory;
  for (int k = 0; k < 6; ++k) {
    const double truth = 0.5 * k * M_PI / 180.0, half = 0.5 * k * M_PI / 180.0;
    absl::StrAppendFormat(&poses, "%.17g 0 %.17g 0 0 1 0 0 %.17g 0 %.17g %d\n", std::cos(truth),
                          std::sin(truth), -std::sin(truth), std::cos(truth), k);
    absl::StrAppendFormat(&trajectory, "%.6f 0 0 %g 0 %.17g 0 %.17g\n", k / 25.0, 0.1 * k,
                          std::sin(half), std::cos(half));
  }
  Write(Root() + "/poses.txt", poses);
  Write(Root() + "/camera.json",
        R"({"focal_pixels": 100, "radial": 0, "width": 96, "height": 64, "frames_per_second": 5})");
  Write(run.folder.File("trajectory.txt"), trajectory);
  Write(run.folder.File("camera.json"),
        R"({"focal_pixels": 95, "radial": 0, "width": 96, "height": 64})");
  const auto scores = ScoreFurther(run.folder, FindFurtherTruth(run.frames), {});
  ASSERT_TRUE(scores.ok()) << scores.status();
  ASSERT_TRUE(scores->trajectory.has_value());
  EXPECT_EQ(scores->trajectory->frames, 6);
  EXPECT_NEAR(*scores->trajectory->rotation, 2.5, 1e-9);
  EXPECT_NEAR(*scores->focal_error_percent, -5.0, 1e-9);
  EXPECT_FALSE(scores->shifted.has_value());
}

TEST(FurtherTruth, RowsThatFitAnotherFrameBetterAreTold) {
  const FakeRun run = WriteFakeRun(Root());
  std::string poses, trajectory;
  for (int k = 0; k < 6; ++k) {
    // Row k holds the pose of frame k + 1; the angle grows with the square.
    const double next = (k + 1) * (k + 1) * M_PI / 180.0, half = 0.5 * k * k * M_PI / 180.0;
    absl::StrAppendFormat(&poses, "%.17g 0 %.17g 0 0 1 0 0 %.17g 0 %.17g %d\n", std::cos(next),
                          std::sin(next), -std::sin(next), std::cos(next), k);
    absl::StrAppendFormat(&trajectory, "%.6f 0 0 %g 0 %.17g 0 %.17g\n", k / 25.0, 0.1 * k,
                          std::sin(half), std::cos(half));
  }
  Write(Root() + "/poses.txt", poses);
  Write(run.folder.File("trajectory.txt"), trajectory);
  FurtherOptions options;
  options.trajectory.frames_per_second = 5.0;
  options.trajectory.span_seconds = 0.2;
  const auto scores = ScoreFurther(run.folder, FindFurtherTruth(run.frames), options);
  ASSERT_TRUE(scores.ok()) << scores.status();
  EXPECT_NEAR(*scores->trajectory->rotation, 10.0, 1e-6);  // 2 degrees in a fifth of a second
  ASSERT_TRUE(scores->shifted.has_value());
  EXPECT_EQ(scores->row_shift, 1);
  EXPECT_NEAR(*scores->shifted->rotation, 0.0, 1e-6);
  EXPECT_THAT(ToTable(*scores), HasSubstr("frame k+1"));
}

TEST(FurtherTruth, TheOwnVehiclesShareIsTheMeanOverFrames) {
  const FakeRun run = WriteFakeRun(Root());
  cv::imwrite(Root() + "/own_vehicle.png", FakeMask({}, 3));  // the disc of frame 3
  const auto scores = ScoreFurther(run.folder, FindFurtherTruth(run.frames), {});
  ASSERT_TRUE(scores.ok()) << scores.status();
  // Marked wholly in frame 3, partly in the others.
  EXPECT_GT(*scores->own_vehicle_marked, 0.2);
  EXPECT_LT(*scores->own_vehicle_marked, 1.0);
}

}  // namespace
}  // namespace egosieve::tools
