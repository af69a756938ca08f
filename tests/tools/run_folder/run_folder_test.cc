#include "tools/run_folder/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "absl/strings/str_split.h"
#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tests/tools/testing/fake_run.h"
#include "tools/run_folder/folder_lock.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/json_name.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

using ::testing::HasSubstr;

TEST(FrameLine, ALineComesBackAsItWas) {
  FrameLine line{.index = 41,
                 .image = "cam0/000012.jpg",
                 .time_seconds = 1.64,
                 .outcome = FrameLine::Outcome::kLearnt,
                 .features = 3000,
                 .matches = 1502,
                 .motion_model = "fundamental",
                 .inliers = 1203,
                 .noise_pixels = 0.4,
                 .labelled_static = 1301,
                 .labelled_dynamic = 204,
                 .frame_gap = 3,
                 .decided_by = {{"epipolar", 0.75}, {"road", 0.25}},
                 .points = {1505, 907, 488, 110, 19, 51, 7, 102},
                 .model_size = 3999,
                 .theta = {0.1, -1.0 / 3.0, 1e-300},
                 .a = 2.5,
                 .b = -0.25,
                 .log_likelihood_per_point = -123.456,
                 .factor_rebuilt = true,
                 .jitter = 1e-9,
                 .dynamic_share = 0.125,
                 .expected_overlap = 0.75,
                 .clamped_variances = 3,
                 .saturated_deviations = 4,
                 .milliseconds = {{"zeta", 1.5}, {"alpha", 2.5}}};
  const std::string text = ToText(line);
  EXPECT_EQ(text.find('\n'), std::string::npos);
  const FrameLine read = Value(FrameLineFromText(text));
  EXPECT_EQ(ToText(read), text);
  EXPECT_EQ(read.points.dropped_by_budget, 102);
  EXPECT_EQ(read.theta, line.theta);
  EXPECT_EQ(read.expected_overlap, 0.75);
  EXPECT_EQ(read.milliseconds, line.milliseconds);
  EXPECT_THAT(text, HasSubstr("\"reason\":null"));
}

TEST(FrameLine, NumbersThatAreNotFiniteAndBrokenTextSurvive) {
  const FrameLine line{.reason = "bad \xff\n\"name\"",
                       .log_likelihood_per_point = std::numeric_limits<double>::quiet_NaN()};
  const FrameLine read = Value(FrameLineFromText(ToText(line)));
  EXPECT_TRUE(std::isnan(read.log_likelihood_per_point));
  EXPECT_THAT(read.reason, HasSubstr("\"name\""));
}

// JSON holds UTF-8 alone.
TEST(JsonName, NamesOfAnyBytesComeBack) {
  for (const std::string name :
       {"", "plain.jpg", "per%d.jpg", "100%.jpg", "line\nbreak.jpg", "q\".jpg",
        "stra\xc3\x9f"
        "e.jpg",
        "\xf0\x9f\x9a\x97.png",
        "stra\xdf"
        "e.jpg",
        "50%\xff", "\xc3", "\xed\xa0\x80", "\xc0\xaf", "\xf4\x90\x80\x80", "\xe0\x80\x80",
        "a\xf0\x9f\x9a"}) {
    const std::string text = JsonName(name);
    EXPECT_NO_THROW(static_cast<void>(nlohmann::json(text).dump())) << text;
    EXPECT_EQ(NameFromJson(text), name);
  }
  EXPECT_EQ(JsonName("per%d.jpg"), "per%d.jpg");
  EXPECT_EQ(JsonName("50%\xdf\xc3\x9f.jpg"), "50%25%DF\xc3\x9f.jpg");

  FrameLine line;
  line.image =
      "stra\xdf"
      "e.jpg";
  EXPECT_EQ(FrameLineFromText(ToText(line))->image, "stra%DFe.jpg");
  RunDescription run{.grid = {8, 6, 2}};
  run.input.path =
      "/drives/stra\xdf"
      "e";
  run.input.remarks = {"2 HEIC files are left out"};
  EXPECT_EQ(RunDescriptionFromText(ToText(run))->input.path, run.input.path);
  EXPECT_EQ(RunDescriptionFromText(ToText(run))->input.remarks, run.input.remarks);
}

TEST(FrameLine, DamageNamesTheField) {
  nlohmann::ordered_json json = ToJson(FrameLine());
  json["matches"] = "many";
  EXPECT_THAT(FrameLineFromJson(json).status().message(), HasSubstr("'matches'"));
  json = ToJson(FrameLine());
  json.erase("theta");
  EXPECT_THAT(FrameLineFromJson(json).status().message(), HasSubstr("'theta'"));
  json = ToJson(FrameLine());
  json["outcome"] = "lost";
  EXPECT_THAT(FrameLineFromJson(json).status().message(), HasSubstr("lost"));
  EXPECT_FALSE(FrameLineFromText("{\"index\":").ok());
  EXPECT_FALSE(FrameLineFromText("[]").ok());
}

TEST(MapImage, ValuesComeBackWithinHalfAStep) {
  const std::string path = FreshFolder() + ".png";
  cv::Mat1f values(7, 9);
  for (int i = 0; i < 63; ++i) values(i / 9, i % 9) = static_cast<float>(i) / 62.0f * 4.0f;
  const EncodedMap encoded = Value(EncodeMap(values, 4.0));
  EXPECT_EQ(encoded.saturated, 0);
  ASSERT_TRUE(WriteFileAtomically(path, encoded.png).ok());
  const cv::Mat1f read = Value(ReadMap(path, values.size(), 4.0));
  // Half a step of 4 / 65535, and the rounding of a float of size 4.
  EXPECT_LE(cv::norm(values, read, cv::NORM_INF), 4.0 / 131070 + 4.0 * 0x1p-23);
  EXPECT_EQ(ReadMap(path, cv::Size(8, 7), 4.0).status().code(), absl::StatusCode::kDataLoss);
  values(3, 3) = 5.0f;
  EXPECT_EQ(EncodeMap(values, 4.0)->saturated, 1);
  values(3, 3) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(std::string(EncodeMap(values, 4.0).status().message()), HasSubstr("column 3, row 3"));
}

TEST(MapImage, ATruncatedFileIsDataLoss) {
  const FakeRun run = WriteFakeRun(FreshFolder());
  const std::string path = run.folder.FrameFile("grid", 1, ".prob.png");
  for (const size_t size : {size_t{0}, size_t{20}}) {
    std::filesystem::resize_file(path, size);
    EXPECT_THAT(run.folder.ReadGridMaps(run.folder.ReadLines()->at(1), run.description, false),
                IsError(absl::StatusCode::kDataLoss, path));
  }
}

TEST(RunFolder, WhatIsWrittenIsRead) {
  const FakeRun run = WriteFakeRun(FreshFolder());
  const RunFolder opened = Value(RunFolder::Open(run.folder.path()));
  const RunDescription description = Value(opened.ReadDescription());
  EXPECT_EQ(ToText(description), ToText(run.description));
  EXPECT_EQ(description.grid.columns(), 20);
  const auto lines = Value(opened.ReadLines());
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[4].reason, "7 matches; 8 are needed");
  const auto maps = Value(opened.ReadGridMaps(lines[2], description, true));
  EXPECT_EQ(maps.probability.size(), cv::Size(20, 14));
  EXPECT_NEAR(maps.deviation(0, 0), 0.4, 4.0 / 131070 + 1e-7);
}

std::set<std::string> NamesBelow(const std::string& path) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
    names.insert(std::filesystem::relative(entry.path(), path).string());
  }
  return names;
}

TEST(RunFolder, IsCreatedWhereNothingIsAndRefusedElsewhere) {
  const std::string root = FreshFolder();
  ASSERT_TRUE(RunFolder::Create(root + "/deep/er", false).ok());
  const FakeRun run = WriteFakeRun(root);
  const std::string path = run.folder.path();

  EXPECT_EQ(RunFolder::Create(path, false).status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_THAT(std::string(RunFolder::Create(path, false).status().message()),
              HasSubstr("--overwrite"));
  const std::vector<std::string> derived = absl::StrSplit(
      "full/000001.prob.png full/000001.objects.json render/000001.png report.html "
      "report.html.abcdef.egosieve.tmp overlay.mp4 preview.png view.rrd "
      "overlay.mp4.abcdef.egosieve.tmp.mp4 "
      "eval.json eval.csv model/000003.npz model/000003.npz.abcdef.egosieve.tmp "
      "model/1000000.npz frames.jsonl.abcdef.egosieve.tmp "
      "grid/000001.prob.png.abcdef.egosieve.tmp run.json.abcdef.egosieve.tmp "
      "log/1-host-2.jsonl plots/index.html plots/roc.svg",
      ' ');
  for (const std::string& name : derived) {
    std::filesystem::create_directories(std::filesystem::path(path + "/" + name).parent_path());
    std::ofstream(path + "/" + name) << "old";
  }
  std::ofstream(path + "/plots/figures.json") << "[{\"id\": \"roc\"}]";
  ASSERT_TRUE(RunFolder::Create(path, true).ok());
  EXPECT_THAT(NamesBelow(path), testing::ElementsAre("grid"));
}

TEST(RunFolder, LeavesWhatIsNotTheProgramsAndNamesIt) {
  const std::string root = FreshFolder();
  const FakeRun run = WriteFakeRun(root);
  const std::string path = run.folder.path();
  const std::vector<std::string> mine = {"notes.txt",      "render/mine.png", "render/00001.png",
                                         "plots/mine.png", "run.json.bak",    "grid/000001.prob"};
  for (const std::string& name : mine) {
    std::filesystem::create_directories(std::filesystem::path(path + "/" + name).parent_path());
    std::ofstream(path + "/" + name) << "mine";
  }
  std::filesystem::create_directories(root + "/elsewhere");
  std::ofstream(root + "/elsewhere/000001.prob.png") << "mine";
  std::filesystem::create_directory_symlink(root + "/elsewhere", path + "/full");
  testing::internal::CaptureStderr();
  ASSERT_TRUE(RunFolder::Create(path, true).ok());
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr("left in " + path));
  EXPECT_THAT(said, HasSubstr("and 2 more"));
  EXPECT_TRUE(std::filesystem::exists(root + "/elsewhere/000001.prob.png"));
  EXPECT_THAT(NamesBelow(path), testing::IsSupersetOf(mine));
  EXPECT_THAT(NamesBelow(path), testing::Not(testing::Contains("run.json")));
  EXPECT_TRUE(std::filesystem::is_symlink(path + "/full"));
}

TEST(RunFolder, RemovesNothingFromWhatIsNoRun) {
  const FakeRun run = WriteFakeRun(FreshFolder());
  EXPECT_EQ(RunFolder::Create(run.frames, true).status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_TRUE(std::filesystem::exists(run.frames + "/000000.png"));
  EXPECT_EQ(RunFolder::Create(run.frames + "/000000.png", true).status().code(),
            absl::StatusCode::kAlreadyExists);
  EXPECT_FALSE(RunFolder::Create("/proc/egosieve", false).ok());
}

// Locks of regular files, which NFS keeps, too; the file stays, so that nobody locks another's.
TEST(RunFolder, LocksAreHeldOnFilesThatStay) {
  const FakeRun run = WriteFakeRun(FreshFolder());
  const std::string path = run.folder.path(), file = path + "/.write.lock";
  struct stat before = {}, after = {};
  {
    const auto lock = Value(FolderLock::Take(path));
    ASSERT_EQ(stat(file.c_str(), &before), 0);
    const int other = open(file.c_str(), O_RDWR | O_CLOEXEC);
    EXPECT_NE(flock(other, LOCK_EX | LOCK_NB), 0);
    close(other);
    EXPECT_EQ(FolderLock::Take(path).status().code(), absl::StatusCode::kFailedPrecondition);
    // Made anew under the lock, by the program that holds it.
    ASSERT_TRUE(RunFolder::Create(path, true).ok());
    ASSERT_EQ(stat(file.c_str(), &after), 0);
    EXPECT_EQ(after.st_ino, before.st_ino);
    EXPECT_FALSE(FolderLock::Take(path).ok());
  }
  EXPECT_TRUE(FolderLock::Take(path).ok());
  EXPECT_EQ(FolderLock::Take(path + "/none").status().code(), absl::StatusCode::kUnavailable);
}

TEST(RunFolder, NoLockIsLeftInTheFolderOfAnother) {
  const std::string root = FreshFolder();
  std::ofstream(root + "/mine") << "mine";
  const auto lock = Value(RunFolder::TakeOrMake(root));
  EXPECT_FALSE(lock.has_value());
  EXPECT_THAT(NamesBelow(root), testing::ElementsAre("mine"));
  EXPECT_TRUE((*RunFolder::TakeOrMake(root + "/new")).has_value());
  EXPECT_TRUE(RunFolder::Create(root + "/new", false).ok());
}

// Lines of maps that were made later come from logs of their own, whoever wrote them.
TEST(RunFolder, LinesAreThoseOfAllLogs) {
  const FakeRun run = WriteFakeRun(FreshFolder());
  std::vector<FrameLine> lines = *run.folder.ReadLines();
  FrameLine without = lines[2], later = lines[2], behind = lines[5];
  without.width_pixels = 0;
  without.dynamic_share = 0.9;
  later.dynamic_share = 0.7;
  behind.index = 9;
  {
    LineLog log = Value(run.folder.OpenMapLog());
    for (const FrameLine& line : {later, without, behind}) {
      ASSERT_TRUE(log.Append(ToText(line)).ok());
    }
  }
  lines = *run.folder.ReadLines();
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_EQ(lines[2].dynamic_share, 0.7);
  EXPECT_EQ(lines[6].index, 9);
  EXPECT_EQ(run.folder.ReadSegmentedLines()->size(), 6u);
}

// Otherwise --resume could not begin again what was killed before its run.json.
TEST(RunFolder, IsCreatedAgainWhereItHadBarelyBegun) {
  const std::string root = FreshFolder();
  ASSERT_TRUE(RunFolder::Create(root, false).ok());
  EXPECT_TRUE(RunFolder::Create(root, false).ok());
  std::ofstream(root + "/run.json.abcdef.egosieve.tmp") << "{";
  EXPECT_TRUE(RunFolder::Create(root, false).ok());
  std::ofstream(root + "/grid/000000.prob.png") << "somebody's";
  EXPECT_EQ(RunFolder::Create(root, false).status().code(), absl::StatusCode::kAlreadyExists);
}

TEST(RunFolder, OpenSaysWhatIsMissing) {
  EXPECT_EQ(RunFolder::Open("/nowhere").status().code(), absl::StatusCode::kNotFound);
  const FakeRun run = WriteFakeRun(FreshFolder());
  EXPECT_EQ(RunFolder::Open(run.frames).status().code(), absl::StatusCode::kNotFound);
}

TEST(RunFolder, DamageIsReportedWithItsPlace) {
  const FakeRun run = WriteFakeRun(FreshFolder());
  const std::string log = run.folder.File("frames.jsonl");
  const std::string text = *ReadFile(log);
  std::ofstream(log) << text << "{\"index\": 6, \"ti";
  EXPECT_EQ(run.folder.ReadLines()->size(), 6u);
  std::ofstream(log) << text << "rubbish\n";
  EXPECT_THAT(run.folder.ReadLines().status().message(), HasSubstr("line 7"));
  std::ofstream(log) << text << text;
  EXPECT_THAT(run.folder.ReadLines().status().message(), HasSubstr("frame 0 comes after frame 5"));

  std::ofstream(run.folder.File("run.json"))
      << "{\"format\": \"egosieve run\", \"format_version\": 99}";
  EXPECT_EQ(run.folder.ReadDescription().status().code(), absl::StatusCode::kFailedPrecondition);
  std::ofstream(run.folder.File("run.json"))
      << "{\"format\": \"egosieve run\", \"format_version\": 1}";
  EXPECT_THAT(std::string(run.folder.ReadDescription().status().message()),
              HasSubstr("segment the drive again"));
  std::ofstream(run.folder.File("run.json")) << "{\"format\": \"other\"}";
  EXPECT_EQ(run.folder.ReadDescription().status().code(), absl::StatusCode::kDataLoss);
}

TEST(RunDescription, NamesTheFirstDifference) {
  const RunDescription before{.flags = {{"stride", "5"}, {"seed", "1"}}};
  RunDescription now = before;
  EXPECT_EQ(DescribeDifference(before, now), "");
  now.flags["stride"] = "3";
  EXPECT_EQ(DescribeDifference(before, now), "stride is '5' there and '3' here");
  now = before;
  now.flags.erase("seed");
  EXPECT_EQ(DescribeDifference(before, now), "seed is '1' there and absent here");
  now = before;
  now.device = "other";
  EXPECT_THAT(DescribeDifference(before, now), HasSubstr("device"));
}

TEST(RunFolder, WhatKilledProgramsLeftIsRemovedInAllItsFolders) {
  const std::string root = FreshFolder();
  const std::vector<std::string> left = {"/report.html.aBbCcD.egosieve.tmp",
                                         "/render/000001.png.aBbCcD.egosieve.tmp",
                                         "/full/000001.objects.json.aBbCcD.egosieve.tmp"};
  const std::vector<std::string> others = {"/render/000001.png", "/render/notes.tmp",
                                           "/movie.abcdef.tmp", "/render/000002.png.abcdef.tmp.png",
                                           "/mine/000001.png.aBbCcD.egosieve.tmp"};
  for (const auto* files : {&left, &others}) {
    for (const std::string& file : *files) {
      std::filesystem::create_directories(std::filesystem::path(root + file).parent_path());
      std::ofstream(root + file) << "half";
    }
  }
  RemoveAbandonedFiles(root);
  for (const std::string& file : left) EXPECT_FALSE(std::filesystem::exists(root + file)) << file;
  for (const std::string& file : others) EXPECT_TRUE(std::filesystem::exists(root + file)) << file;
}

TEST(LiesInFolder, OfPathsThatDoNotExist) {
  const std::string here = std::filesystem::current_path().string();
  EXPECT_TRUE(LiesInFolder(here + "/none/masks", "none"));
  EXPECT_TRUE(LiesInFolder("none/masks", here + "/none"));
  EXPECT_FALSE(LiesInFolder(here + "/others/masks", "none"));
}

}  // namespace
}  // namespace egosieve::tools
