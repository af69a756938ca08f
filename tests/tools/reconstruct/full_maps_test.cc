#include "tools/reconstruct/full_maps.h"

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fake_run.h"
#include "tests/tools/testing/run_command.h"
#include "tools/reconstruct/reconstruct_command.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

TEST(InterpolateMap, IsExactForLinearMaps) {
  const absl::StatusOr<std::shared_ptr<kernels::Context>> context = kernels::OpenContext({});
  ASSERT_TRUE(context.ok()) << context.status();
  const kernels::ImageGrid grid{43, 29, 5};  // the last cells are narrower
  const auto plane = [](double x, double y) { return 0.1 + 0.013 * x + 0.007 * y; };
  cv::Mat1f values(grid.rows(), grid.columns());
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      values(row, column) = static_cast<float>(plane(grid.x_pixels(column), grid.y_pixels(row)));
    }
  }
  const absl::StatusOr<cv::Mat1f> full = InterpolateMap(**context, grid, values);
  ASSERT_TRUE(full.ok()) << full.status();
  ASSERT_EQ(full->size(), cv::Size(43, 29));
  for (int y = 0; y < 29; ++y) {
    for (int x = 0; x < 43; ++x) {
      // Four products and sums of floats below 1: a few units in the last place, 6e-8 each.
      ASSERT_NEAR((*full)(y, x), plane(x, y), 5e-7) << x << ", " << y;
    }
  }
}

TEST(ClassifyMap, HasThreeClasses) {
  const cv::Mat1f probability = (cv::Mat1f(1, 5) << 0.0f, 0.39f, 0.5f, 0.75f, 0.76f);
  const cv::Mat1b classes = ClassifyMap(probability, {0.4, 0.75});
  const cv::Mat1b expected = (cv::Mat1b(1, 5) << 0, 0, 128, 128, 255);
  EXPECT_EQ(cv::norm(classes, expected, cv::NORM_INF), 0.0);
}

TEST(ReconstructCommand, WritesMapsOfTheFramesSize) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/reconstruct");
  EXPECT_EQ(RunCommandForTest(MakeReconstructCommand(), {run.folder.path()}).code, 0);
  const cv::Mat probability = cv::imread(run.folder.FrameFile("full", 3, ".prob.png"), -1);
  const cv::Mat deviation = cv::imread(run.folder.FrameFile("full", 3, ".std.png"), -1);
  const cv::Mat classes = cv::imread(run.folder.FrameFile("full", 3, ".class.png"), -1);
  EXPECT_EQ(probability.size(), cv::Size(96, 64));
  EXPECT_EQ(probability.type(), CV_16UC1);
  EXPECT_EQ(deviation.at<uint16_t>(10, 10), std::lround(0.4 / 4.0 * 65535));
  EXPECT_EQ(classes.type(), CV_8UC1);
  EXPECT_EQ(classes.at<uint8_t>(0, 95), 0);
  EXPECT_EQ(classes.at<uint8_t>(32, 33), 255);  // the disc's centre in frame 3
}

TEST(ReconstructCommand, ListsObjects) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/reconstruct_objects");
  ASSERT_EQ(RunCommandForTest(MakeReconstructCommand(), {run.folder.path()}).code, 0);
  const auto objects_of = [&](int frame) {
    return nlohmann::json::parse(*ReadFile(run.folder.FrameFile("full", frame, ".objects.json")));
  };
  EXPECT_TRUE(objects_of(0).empty());  // the prior is likely everywhere, and sure nowhere
  const nlohmann::json objects = objects_of(3);
  ASSERT_EQ(objects.size(), 1u);
  const cv::Mat points = FakeMask({}, 3);
  const cv::Rect disc = cv::boundingRect(points);
  const auto box = objects[0].at("box").get<std::vector<int>>();
  const cv::Rect found(box[0], box[1], box[2], box[3]);
  EXPECT_GT((found & disc).area(), 0.9 * disc.area());
  EXPECT_LT(found.area(), 2.0 * disc.area());  // a grid pixel is 5 pixels wide
  EXPECT_GT(objects[0].at("peak_probability"), 0.85);
  EXPECT_NEAR(objects[0].at("mean_deviation").get<double>(), 0.4, 1e-4);
  ASSERT_EQ(
      RunCommandForTest(MakeReconstructCommand(), {run.folder.path(), "--object_high=0.99"}).code,
      0);
  EXPECT_TRUE(objects_of(3).empty());
}

TEST(ReconstructCommand, SaysWhatIsWrong) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/reconstruct_bad");
  const CommandOutcome swapped = RunCommandForTest(
      MakeReconstructCommand(), {run.folder.path(), "--static_below=0.8", "--dynamic_above=0.2"});
  EXPECT_EQ(swapped.code, 2);
  EXPECT_THAT(swapped.err, HasSubstr("--static_below=0.8"));
  const CommandOutcome low_above_high =
      RunCommandForTest(MakeReconstructCommand(), {run.folder.path(), "--object_low=0.9"});
  EXPECT_EQ(low_above_high.code, 2);
  EXPECT_THAT(low_above_high.err, HasSubstr("--object_low=0.9"));
  EXPECT_EQ(RunCommandForTest(MakeReconstructCommand(), {"/nowhere"}).code, 3);
  std::filesystem::remove(run.folder.FrameFile("grid", 2, ".prob.png"));
  const CommandOutcome missing = RunCommandForTest(MakeReconstructCommand(), {run.folder.path()});
  EXPECT_EQ(missing.code, 3);
  EXPECT_THAT(missing.err, HasSubstr("000002.prob.png"));
}

}  // namespace
}  // namespace egosieve::tools
