#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "gmock/gmock.h"
#include "tests/tools/testing/fake_run.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/run_command.h"
#include "tools/cli/command.h"
#include "tools/render/overlay.h"
#include "tools/render/render_run.h"

namespace egosieve::tools {
namespace {

CommandOutcome Render(const std::vector<std::string>& words) {
  return RunCommandForTest(MakeRenderCommand(), words);
}

TEST(DrawOverlay, TintsByProbabilityAndKeepsSidesEven) {
  const cv::Mat3b frame(121, 201, cv::Vec3b(100, 100, 100));
  cv::Mat1f probability(frame.size(), 0.5f);
  probability(cv::Rect(0, 0, 60, 121)) = 0.0f;
  probability(cv::Rect(140, 0, 61, 121)) = 1.0f;
  const cv::Mat3b overlay = DrawOverlay(frame, probability, "frame 7");
  EXPECT_EQ(overlay.cols, 202);
  EXPECT_GE(overlay.rows, 121 + 20);
  EXPECT_EQ(overlay.rows % 2, 0);
  const cv::Vec3b still = overlay(60, 20), moving = overlay(60, 180), unsure = overlay(60, 100);
  EXPECT_GT(still[0], still[2] + 20);    // blue
  EXPECT_GT(moving[2], moving[0] + 60);  // orange
  EXPECT_EQ(unsure[0], unsure[2]);       // no colour
  EXPECT_EQ(DrawOverlay(frame, probability, "", {.legend = false}).size(), cv::Size(202, 122));
}

TEST(DrawOverlay, DrawsLinesAroundObjectsAlone) {
  const cv::Mat3b frame(120, 200, cv::Vec3b(100, 100, 100));
  cv::Mat1f probability(frame.size(), 0.1f);
  probability(cv::Rect(20, 20, 40, 40)) = 0.4f;
  probability(cv::Rect(35, 35, 5, 5)) = 0.9f;
  probability(cv::Rect(120, 20, 40, 40)) = 0.79f;
  OverlayOptions bare{.legend = false};
  const cv::Mat3b overlay = DrawOverlay(frame, probability, "", bare);
  bare.objects = {1.0, 1.0};
  const cv::Mat3b lineless = DrawOverlay(frame, probability, "", bare);
  const auto change = [&](int x, int y) { return cv::norm(overlay(y, x), lineless(y, x)); };
  EXPECT_GT(change(20, 40), 100.0);
  EXPECT_EQ(change(35, 37), 0.0);  // within the object
  EXPECT_EQ(change(120, 40), 0.0);
}

// Of a portrait video, too: the caption, at the right, is there.
TEST(DrawMovers, TellsTheFrameInANarrowPicture) {
  const cv::Mat3b frame(640, 352, cv::Vec3b(128, 128, 128));
  const cv::Mat1w ids = cv::Mat1w::zeros(frame.size());
  const auto caption_of = [&](const char* caption) {
    const cv::Mat3b page = DrawMovers(frame, ids, caption);
    return cv::Mat3b(page(cv::Rect(200, 640, 152, page.rows - 640)).clone());
  };
  EXPECT_GT(cv::norm(caption_of("frame 175  5.83 s"), caption_of("frame 264  7.41 s")), 100.0);
}

TEST(DrawMovers, FillsOrOutlinesThem) {
  const cv::Mat3b frame(120, 200, cv::Vec3b(128, 128, 128));
  cv::Mat1w ids = cv::Mat1w::zeros(frame.size());
  ids(cv::Rect(40, 40, 60, 50)) = 3;
  OverlayOptions bare{.legend = false};
  const cv::Mat3b filled = DrawMovers(frame, ids, "", bare);
  EXPECT_EQ(filled(10, 10), frame(10, 10));
  EXPECT_NE(filled(75, 75), frame(75, 75));
  EXPECT_NE(MoverColour(3), MoverColour(4));
  bare.outlines_only = true;
  const cv::Mat3b outlined = DrawMovers(frame, ids, "", bare);
  EXPECT_EQ(outlined(75, 75), frame(75, 75));
  EXPECT_NE(outlined(75, 40), frame(75, 40));
}

TEST(FrameRate, IsTheMedianAndHasADefault) {
  std::vector<FrameLine> lines(4);
  for (int i = 0; i < 4; ++i) lines[i].index = i;
  EXPECT_EQ(FrameRate(lines), 10.0);
  lines[1].time_seconds = 0.04;
  lines[2].time_seconds = 0.08;
  lines[3].time_seconds = 9.0;
  EXPECT_NEAR(FrameRate(lines), 25.0, 1e-9);
}

TEST(RenderCommand, WritesImagesAndAVideoThatPlays) {
  const FakeRunOptions options{.width_pixels = 161, .height_pixels = 121};
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/render", options);
  EXPECT_THAT(Render({run.folder.path()}), Succeeds());
  EXPECT_TRUE(std::filesystem::exists(run.folder.File("overlay.mp4")));
  EXPECT_FALSE(std::filesystem::exists(run.folder.File("render")));
  EXPECT_THAT(Render({run.folder.path(), "--images"}), Succeeds());
  const cv::Mat image = cv::imread(run.folder.FrameFile("render", 5, ".png"));
  ASSERT_FALSE(image.empty());
  cv::VideoCapture video(run.folder.File("overlay.mp4"));
  ASSERT_TRUE(video.isOpened());
  int frames = 0;
  cv::Mat decoded;
  while (video.read(decoded)) {
    EXPECT_EQ(decoded.size(), image.size());
    ++frames;
  }
  EXPECT_EQ(frames, 6);
  EXPECT_FALSE(std::filesystem::exists(run.folder.File("overlay.tmp.mp4")));
}

TEST(RenderCommand, SaysWhenTheInputIsGoneOrAnother) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/render_bad");
  const std::string moved = run.frames + "_moved";
  std::filesystem::remove_all(moved);
  std::filesystem::rename(run.frames, moved);
  EXPECT_THAT(Render({run.folder.path()}), Says(3, "--input="));
  EXPECT_THAT(Render({run.folder.path(), "--input=" + moved, "--images", "--no_video"}),
              Succeeds());
  cv::imwrite(moved + "/000003.png", cv::Mat3b(10, 10));
  EXPECT_THAT(Render({run.folder.path(), "--input=" + moved, "--images", "--no_video"}),
              Says(3, "frame 3"));
  EXPECT_EQ(Render({run.folder.path(), "--no_video"}).code, 2);
}

}  // namespace
}  // namespace egosieve::tools
