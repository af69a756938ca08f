#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_split.h"
#include "tests/testing/status.h"
#include "tests/tools/testing/fake_run.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/run_command.h"
#include "tools/refine/full_maps.h"
#include "tools/refine/refine_run.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

CommandOutcome Refine(const std::vector<std::string>& words) {
  return RunCommandForTest(MakeRefineCommand(), words);
}

TEST(RefineCommand, WritesMapsOfTheFramesSize) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/refine");
  ASSERT_THAT(Refine({run.folder.path(), "--what=probability,deviation,class"}), Succeeds());
  EXPECT_FALSE(std::filesystem::exists(run.folder.File("masks")));
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

TEST(RefineCommand, ListsObjects) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/refine_objects");
  ASSERT_THAT(Refine({run.folder.path()}), Succeeds());
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
  EXPECT_GT(objects[0].at("sure"), 0.3);
  ASSERT_THAT(Refine({run.folder.path(), "--object_high=0.9999"}), Succeeds());
  EXPECT_TRUE(objects_of(3).empty());
}

TEST(RefineCommand, WritesMasksNumbersAndTracks) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/refine_masks");
  ASSERT_THAT(Refine({run.folder.path()}), Succeeds());
  const cv::Mat mask = cv::imread(run.folder.FrameFile("masks", 3, ".png"), -1);
  const cv::Mat ids = cv::imread(run.folder.FrameFile("ids", 3, ".png"), -1);
  ASSERT_EQ(mask.type(), CV_8UC1);
  ASSERT_EQ(ids.type(), CV_16UC1);
  const cv::Mat1b disc = FakeMask({}, 3);
  EXPECT_GT(cv::countNonZero(mask & disc), 0.8 * cv::countNonZero(mask | disc));
  EXPECT_EQ(cv::countNonZero((mask != 0) != (ids != 0)), 0);
  // The first frame has the prior, and its neighbour, noise that no flow holds, tells it nothing.
  EXPECT_EQ(cv::countNonZero(cv::imread(run.folder.FrameFile("masks", 0, ".png"), -1)), 0);
  const std::vector<std::string> rows =
      absl::StrSplit(*ReadFile(run.folder.File("tracks.csv")), '\n', absl::SkipEmpty());
  ASSERT_GE(rows.size(), 6u);
  EXPECT_EQ(rows[0], kTracksHeader);
  const std::vector<std::string> row = absl::StrSplit(rows[3], ',');
  ASSERT_EQ(row.size(), 10u);
  EXPECT_EQ(row[0], "3");
  EXPECT_EQ(row[7], std::to_string(cv::countNonZero(mask)));
  EXPECT_FALSE(std::filesystem::exists(run.folder.FrameFile("full", 3, ".prob.png")));
}

// Frame 31 is the last one of a chunk; the drive's last frame has none after it.
TEST(RefineCommand, AMoverOfASingleFrameIsNone) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/refine_glimpses", {.frames = 40});
  const std::vector<FrameLine> lines = *run.folder.ReadLines();
  // Far apart, so that none is taken for an earlier one that is seen again.
  const std::map<int, cv::Rect> glimpses = {
      {20, {16, 10, 3, 3}}, {31, {0, 10, 3, 3}}, {39, {8, 0, 3, 3}}};  // at grid pixels
  const auto pixels_of = [&](const char* product, int frame) {
    const cv::Mat image = cv::imread(run.folder.FrameFile(product, frame, ".png"), -1);
    const cv::Rect& grid = glimpses.at(frame);
    return cv::countNonZero(
        image(cv::Rect(5 * grid.x, 5 * grid.y, 15, 15) & cv::Rect({0, 0}, image.size())));
  };
  for (const auto& [frame, place] : glimpses) {
    FrameMaps maps = *run.folder.ReadGridMaps(lines[frame], run.description, true);
    maps.probability(place) = 0.95F;
    ASSERT_TRUE(run.folder.WriteGridMaps(frame, maps, run.description.deviation_full_scale).ok());
  }
  ASSERT_THAT(Refine({run.folder.path()}), Succeeds());
  for (const char* product : {"ids", "masks"}) {
    EXPECT_EQ(pixels_of(product, 20), 0) << product;
    EXPECT_EQ(pixels_of(product, 31), 0) << product;
    EXPECT_GT(pixels_of(product, 39), 100) << product;
  }
  ASSERT_THAT(Refine({run.folder.path(), "--causal"}), Succeeds());
  for (const auto& [frame, place] : glimpses) EXPECT_GT(pixels_of("ids", frame), 100) << frame;
}

// All that refine writes, by name.
std::map<std::string, std::string> ProductsOf(const RunFolder& folder) {
  std::map<std::string, std::string> products;
  for (const char* name : {"masks", "ids", "full"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder.File(name))) {
      products[entry.path().filename().string() + name] = *ReadFile(entry.path().string());
    }
  }
  products["tracks"] = *ReadFile(folder.File("tracks.csv"));
  return products;
}

TEST(RefineRun, GoesOnWithTheSameBytes) {
  FakeRunOptions options;
  options.frames = 40;  // more than a chunk
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/refine_resume", options);
  const std::vector<FrameLine> lines = *run.folder.ReadLines();
  RefineOptions what;
  auto whole = Value(RefineRun::Open(run.folder, lines, what));
  ASSERT_TRUE(whole->Run([] { return true; }).ok());
  const std::map<std::string, std::string> expected = ProductsOf(run.folder);

  auto cut_short = Value(RefineRun::Open(run.folder, lines, what));
  EXPECT_EQ(cut_short->Run([] { return false; }).code(), absl::StatusCode::kCancelled);
  EXPECT_NE(ProductsOf(run.folder).at("tracks"), expected.at("tracks"));
  for (int i = 32; i < 40; ++i) {
    std::filesystem::remove(run.folder.FrameFile("masks", i, ".png"));
  }
  what.resume = true;
  auto rest = Value(RefineRun::Open(run.folder, lines, what));
  EXPECT_EQ(rest->frames_done_before(), 32);
  ASSERT_TRUE(rest->Run([] { return true; }).ok());
  EXPECT_EQ(ProductsOf(run.folder), expected);

  what.mask.low = 0.4;
  const auto other = Value(RefineRun::Open(run.folder, lines, what));
  EXPECT_EQ(other->frames_done_before(), 0);
}

TEST(RefineCommand, SaysWhatIsWrongWithTheInput) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/refine_input");
  {
    const FolderLock lock = Value(FolderLock::Take(run.folder.path()));
    EXPECT_THAT(Refine({run.folder.path()}), Says(2, "another program is writing into"));
  }
  const std::string moved = testing::TempDir() + "/refine_moved";
  std::filesystem::remove_all(moved);
  std::filesystem::rename(run.frames, moved);
  EXPECT_THAT(Refine({run.folder.path()}), Says(3, "--input="));
  EXPECT_FALSE(std::filesystem::exists(run.folder.File("masks")));
  EXPECT_THAT(Refine({run.folder.path(), "--input=" + moved}), Succeeds());
  cv::imwrite(moved + "/000004.png", cv::Mat3b(32, 48));
  EXPECT_THAT(Refine({run.folder.path(), "--input=" + moved}),
              Says(3, "is not what was segmented"));
}

TEST(RefineCommand, SaysWhatIsWrong) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/refine_bad");
  EXPECT_THAT(Refine({run.folder.path(), "--static_below=0.8", "--dynamic_above=0.2"}),
              Says(2, "--static_below=0.8"));
  EXPECT_THAT(Refine({run.folder.path(), "--object_low=0.9"}), Says(2, "--object_low=0.9"));
  EXPECT_EQ(Refine({"/nowhere"}).code, 3);
  std::filesystem::remove(run.folder.FrameFile("grid", 2, ".prob.png"));
  EXPECT_THAT(Refine({run.folder.path()}), Says(3, "the map of frame 2 in"));
}

TEST(RefineCommand, ResumesAnewWhereTheFormerOneHadOtherOptions) {
  const FakeRun run = WriteFakeRun(testing::TempDir() + "/refine_anew");
  const auto refine = [&](const std::string& high) {
    return Refine({run.folder.path(), "--mask_high=" + high, "--resume"});
  };
  const auto moving = [&] {
    return cv::countNonZero(cv::imread(run.folder.FrameFile("masks", 3, ".png"), -1));
  };
  ASSERT_THAT(refine("0.7"), Succeeds());
  const int before = moving();
  EXPECT_GT(before, 0);
  ASSERT_THAT(refine("0.999"), Succeeds());
  EXPECT_EQ(moving(), 0);
  ASSERT_THAT(refine("0.7"), Succeeds());
  EXPECT_EQ(moving(), before);
}

TEST(InterpolateMap, IsExactForLinearMaps) {
  const vision::ImageGrid grid{43, 29, 5};  // the last cells are narrower
  const auto plane = [](double x, double y) { return 0.1 + 0.013 * x + 0.007 * y; };
  cv::Mat1f values(grid.rows(), grid.columns());
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      values(row, column) = static_cast<float>(plane(grid.x_pixels(column), grid.y_pixels(row)));
    }
  }
  const cv::Mat1f full = Value(InterpolateMap(grid, values));
  ASSERT_EQ(full.size(), cv::Size(43, 29));
  for (int y = 0; y < 29; ++y) {
    for (int x = 0; x < 43; ++x) {
      // Four products and sums of floats below 1: a few units in the last place, 6e-8 each.
      ASSERT_NEAR(full(y, x), plane(x, y), 5e-7) << x << ", " << y;
    }
  }
}

TEST(ClassifyMap, HasThreeClasses) {
  const cv::Mat1f probability = (cv::Mat1f(1, 5) << 0.0f, 0.39f, 0.5f, 0.75f, 0.76f);
  const cv::Mat1b classes = ClassifyMap(probability, {0.4, 0.75});
  const cv::Mat1b expected = (cv::Mat1b(1, 5) << 0, 0, 128, 128, 255);
  EXPECT_EQ(cv::norm(classes, expected, cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace egosieve::tools
