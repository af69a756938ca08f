#include "tools/masks/masks_command.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fake_run.h"
#include "tests/tools/testing/fresh_folder.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/run_command.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// The pixels of COCO's text for a mask, as maskApi.c reads it.
cv::Mat1b Decoded(const std::string& text, int rows, int columns) {
  std::vector<int64_t> runs;
  for (size_t p = 0; p < text.size();) {
    int64_t x = 0;
    int k = 0;
    bool more = true;
    while (more) {
      const int64_t c = text[p++] - 48;
      x |= (c & 31) << (5 * k++);
      more = (c & 32) != 0;
      if (!more && (c & 16) != 0) x -= int64_t{1} << (5 * k);
    }
    runs.push_back(runs.size() > 2 ? x + runs[runs.size() - 2] : x);
  }
  cv::Mat1b mask(columns, rows, uint8_t{0});  // transposed: runs go down the columns
  int64_t at = 0;
  for (size_t i = 0; i < runs.size(); ++i) {
    for (int64_t j = 0; j < runs[i]; ++j, ++at) mask.data[at] = i % 2 == 1 ? 255 : 0;
  }
  EXPECT_EQ(at, rows * columns);
  return mask.t();
}

class MasksTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = FreshFolder();
    out_ = root_ + "/out";
  }

  CommandOutcome Masks(std::vector<std::string> arguments) const {
    arguments.push_back("--out=" + out_);
    arguments.push_back("--progress=none");
    return RunCommandForTest(MakeMasksCommand(), std::move(arguments));
  }

  cv::Mat Read(const std::string& name) const {
    return cv::imread(out_ + "/" + name, cv::IMREAD_UNCHANGED);
  }

  static cv::Mat Made(const FakeRun& run, const char* folder, int index) {
    return cv::imread(run.folder.FrameFile(folder, index, ".png"), cv::IMREAD_UNCHANGED);
  }

  std::string root_, out_;
};

int Differences(const cv::Mat& a, const cv::Mat& b) {
  EXPECT_EQ(a.size(), b.size());
  EXPECT_EQ(a.type(), b.type());
  return cv::countNonZero(a != b);
}

// Every image has a mask of its name with .png behind it; COLMAP leaves out where it is 0.
TEST_F(MasksTest, OfColmap) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_EQ(Masks({run.folder.path(), "--for=colmap"}).code, 0);
  for (int i = 0; i < 6; ++i) {
    const cv::Mat mask = Read(absl::StrFormat("%06d.png.png", i));
    EXPECT_EQ(Differences(mask, Made(run, "masks", i) == 0), 0) << i;
  }
  EXPECT_GT(cv::countNonZero(Read("000003.png.png") == 0), 100);
  EXPECT_EQ(std::distance(fs::directory_iterator(out_), fs::directory_iterator()), 6);

  out_ = root_ + "/grown";
  ASSERT_EQ(Masks({run.folder.path(), "--for=colmap", "--dilate=4", "--invert"}).code, 0);
  cv::Mat1f distance;
  cv::distanceTransform(Made(run, "masks", 3) == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  EXPECT_EQ(Differences(Read("000003.png.png"), distance <= 4.0), 0);
}

// nerfstudio's rules: a mask_path for every frame, one channel, 0 is left out, relative to the
// file.
TEST_F(MasksTest, OfNerfstudio) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  nlohmann::json transforms = {{"fl_x", 80.0}, {"ply_file_path", "sparse_pc.ply"}};
  for (int i = 5; i >= 0; --i) {
    transforms["frames"].push_back({{"file_path", absl::StrFormat("./frames/%06d.png", i)},
                                    {"transform_matrix", {{1, 0}, {0, 1}}}});
  }
  ASSERT_TRUE(WriteFileAtomically(root_ + "/drive/transforms.json", transforms.dump()).ok());
  ASSERT_EQ(Masks({run.folder.path(), "--for=nerfstudio"}).code, 0);
  const nlohmann::json copy = nlohmann::json::parse(*ReadFile(out_ + "/transforms.json"));
  EXPECT_EQ(copy.at("fl_x"), 80.0);
  EXPECT_EQ(copy.at("ply_file_path"), "../drive/sparse_pc.ply");
  ASSERT_EQ(copy.at("frames").size(), 6u);
  for (const nlohmann::json& frame : copy.at("frames")) {
    const fs::path image = fs::path(out_) / frame.at("file_path").get<std::string>();
    ASSERT_TRUE(fs::exists(image)) << image;
    const int index = std::stoi(image.stem());
    EXPECT_EQ(Differences(Read(frame.at("mask_path")), Made(run, "masks", index) == 0), 0);
    EXPECT_EQ(frame.at("transform_matrix"), transforms["frames"][0]["transform_matrix"]);
  }
}

TEST_F(MasksTest, OfInstantNgpWithPictures) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_EQ(Masks({run.folder.path(), "--for=instant-ngp", "--frames=" + out_}).code, 0);
  EXPECT_EQ(Differences(Read("dynamic_mask_000003.png"), Made(run, "masks", 3)), 0);
  EXPECT_EQ(*ReadFile(out_ + "/000003.png"), *ReadFile(run.frames + "/000003.png"));
}

TEST_F(MasksTest, OfGaussianSplatting) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_EQ(Masks({run.folder.path(), "--for=gaussian-splatting"}).code, 0);
  const cv::Mat picture = Read("000003.png");
  ASSERT_EQ(picture.type(), CV_8UC4);
  cv::Mat alpha, colours;
  cv::extractChannel(picture, alpha, 3);
  cv::cvtColor(picture, colours, cv::COLOR_BGRA2BGR);
  EXPECT_EQ(Differences(alpha, Made(run, "masks", 3) == 0), 0);
  EXPECT_EQ(cv::norm(colours, cv::imread(run.frames + "/000003.png"), cv::NORM_INF), 0.0);
}

// An indexed PNG whose pixels are the movers' numbers; the colours are VOC's.
TEST_F(MasksTest, OfDavis) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_EQ(Masks({run.folder.path(), "--for=davis"}).code, 0);
  const std::string png = *ReadFile(out_ + "/000003.png");
  EXPECT_EQ(png[24], 8);  // bits of a pixel
  EXPECT_EQ(png[25], 3);  // colour type: palette
  const size_t palette = png.find("PLTE");
  ASSERT_NE(palette, std::string::npos);
  const auto colour_of = [&](int label) {
    const auto* rgb = reinterpret_cast<const uint8_t*>(png.data() + palette + 4 + 3 * label);
    return cv::Vec3b(rgb[2], rgb[1], rgb[0]);
  };
  EXPECT_EQ(colour_of(0), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(colour_of(1), cv::Vec3b(0, 0, 128));
  EXPECT_EQ(colour_of(14), cv::Vec3b(128, 128, 64));
  const cv::Mat1w ids = Made(run, "ids", 3);
  const cv::Mat3b shown = cv::imread(out_ + "/000003.png", cv::IMREAD_COLOR);
  for (int y = 0; y < ids.rows; ++y) {
    for (int x = 0; x < ids.cols; ++x) ASSERT_EQ(shown(y, x), colour_of(ids(y, x)));
  }
}

TEST_F(MasksTest, OfCoco) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_EQ(Masks({run.folder.path(), "--for=coco"}).code, 0);
  const nlohmann::json json = nlohmann::json::parse(*ReadFile(out_ + "/annotations.json"));
  ASSERT_EQ(json.at("images").size(), 6u);
  EXPECT_EQ(json.at("images")[3].at("file_name"), "000003.png");
  std::vector<cv::Mat1b> drawn(6);
  for (int i = 0; i < 6; ++i) drawn[i] = cv::Mat1b(64, 96, uint8_t{0});
  for (const nlohmann::json& annotation : json.at("annotations")) {
    EXPECT_THAT(annotation.at("segmentation").at("size").get<std::vector<int>>(),
                ElementsAre(64, 96));
    const cv::Mat1b mask = Decoded(annotation.at("segmentation").at("counts"), 64, 96);
    const int index = annotation.at("image_id").get<int>() - 1;
    EXPECT_EQ(Differences(
                  mask, cv::Mat1w(Made(run, "ids", index)) == annotation.at("track_id").get<int>()),
              0);
    EXPECT_EQ(annotation.at("area"), cv::countNonZero(mask));
    const auto box = annotation.at("bbox").get<std::vector<int>>();
    EXPECT_EQ(cv::Rect(box[0], box[1], box[2], box[3]), cv::boundingRect(mask));
    drawn[index] |= mask;
  }
  EXPECT_EQ(Differences(drawn[3], Made(run, "masks", 3)), 0);
}

// time_frame id class height width text; the image holds 1000 class + number.
TEST_F(MasksTest, OfMots) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_EQ(Masks({run.folder.path(), "--for=mots"}).code, 0);
  const std::vector<std::string> rows =
      absl::StrSplit(*ReadFile(out_ + "/drive.txt"), '\n', absl::SkipEmpty());
  ASSERT_GE(rows.size(), 4u);
  for (const std::string& row : rows) {
    const std::vector<std::string> fields = absl::StrSplit(row, ' ');
    ASSERT_EQ(fields.size(), 6u);
    EXPECT_EQ(fields[2], "1");
    const int index = std::stoi(fields[0]), object = std::stoi(fields[1]);
    const cv::Mat image = Read(absl::StrFormat("drive/%06d.png", index));
    ASSERT_EQ(image.type(), CV_16UC1);
    const cv::Mat1b mask = Decoded(fields[5], std::stoi(fields[3]), std::stoi(fields[4]));
    EXPECT_EQ(Differences(mask, image == object), 0);
    EXPECT_EQ(Differences(mask, cv::Mat1w(Made(run, "ids", index)) == object - 1000), 0);
  }
  EXPECT_EQ(cv::countNonZero(Read("drive/000000.png")), 0);
}

TEST_F(MasksTest, TakesAThresholdWhatIsUnsureAndTheUsersOwn) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_EQ(Masks({run.folder.path(), "--for=plain", "--threshold=0.5"}).code, 0);
  const cv::Mat1b half = Read("000003.png");
  out_ = root_ + "/unsure";
  ASSERT_EQ(Masks({run.folder.path(), "--for=plain", "--unsure=mask"}).code, 0);
  const cv::Mat1b unsure = Read("000003.png");
  const cv::Mat map = cv::imread(run.folder.FrameFile("full", 3, ".prob.png"), -1);
  EXPECT_EQ(Differences(half, map >= 32768), 0);
  EXPECT_EQ(Differences(unsure, map >= 26214), 0);
  EXPECT_FALSE(fs::exists(run.folder.File("masks")));  // nobody asked for these

  const cv::Mat1b corner = (cv::Mat1b(64, 96, uint8_t{0}));
  cv::Mat1b own = corner.clone();
  own(cv::Rect(0, 0, 9, 5)) = 1;
  cv::imwrite(root_ + "/hood.png", own);
  out_ = root_ + "/also";
  ASSERT_EQ(
      Masks({run.folder.path(), "--for=plain", "--threshold=0.5", "--also=" + root_ + "/hood.png"})
          .code,
      0);
  EXPECT_EQ(Differences(Read("000003.png"), half | (own != 0)), 0);

  fs::create_directories(root_ + "/own");
  cv::imwrite(root_ + "/own/000003.png", own);
  out_ = root_ + "/also_some";
  ASSERT_EQ(
      Masks({run.folder.path(), "--for=plain", "--threshold=0.5", "--also=" + root_ + "/own"}).code,
      0);
  EXPECT_EQ(Differences(Read("000003.png"), half | (own != 0)), 0);
}

// From pictures in one call, folders kept, and the run is there for the next one.
TEST_F(MasksTest, SegmentsWhatIsNoRunYet) {
  WritePatchDrive(root_ + "/drive", SmallPatchDrive(6));
  fs::create_directories(root_ + "/images");
  fs::rename(root_ + "/drive/frames", root_ + "/images/cam0");
  testing::internal::CaptureStdout();
  const int code =
      Masks({root_ + "/images", "--for=colmap", "--truth=" + root_ + "/drive/masks", "--json"})
          .code;
  const std::vector<std::string> lines =
      absl::StrSplit(testing::internal::GetCapturedStdout(), '\n', absl::SkipEmpty());
  ASSERT_EQ(code, 0);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(nlohmann::json::parse(lines[0]).at("command"), "segment");
  EXPECT_EQ(nlohmann::json::parse(lines[1]).at("command"), "reconstruct");
  const nlohmann::json result = nlohmann::json::parse(lines[2]);
  EXPECT_EQ(result.at("images"), 6);
  EXPECT_GT(result.at("moving_masked"), 0.5);
  EXPECT_LT(result.at("rest_masked"), 0.2);
  EXPECT_TRUE(fs::exists(out_ + "/cam0/000000.png.png"));
  EXPECT_TRUE(fs::exists(out_ + "/cam0/000005.png.png"));
  EXPECT_TRUE(fs::exists(out_ + ".run/masks/000005.png"));
  const std::string run = out_ + ".run";
  out_ = root_ + "/coco";
  ASSERT_EQ(Masks({run, "--for=coco"}).code, 0);
  EXPECT_TRUE(fs::exists(out_ + "/annotations.json"));
}

TEST_F(MasksTest, GoesOnBehindAPictureThatCannotBeRead) {
  WritePatchDrive(root_ + "/drive", SmallPatchDrive(5));
  ASSERT_TRUE(WriteFileAtomically(root_ + "/drive/frames/000002.png", "no picture").ok());
  for (const std::string& input : {root_ + "/drive/frames", root_ + "/out.run"}) {
    EXPECT_EQ(Masks({input, "--for=plain"}).code, 4) << input;
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(fs::exists(out_ + absl::StrFormat("/%06d.png", i)), i != 2) << i;
    }
    out_ = root_ + "/again";
  }
}

TEST_F(MasksTest, WritesAVideosPictures) {
  cv::VideoWriter video(root_ + "/drive.avi", cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10.0,
                        cv::Size(160, 96));
  for (int i = 0; i < 4; ++i) video << PatchFrame(SmallPatchDrive(4), i);
  video.release();
  const std::string pictures = root_ + "/pictures";
  ASSERT_EQ(
      Masks({root_ + "/drive.avi", "--for=colmap", "--frames=" + pictures, "--run=" + root_ + "/r"})
          .code,
      0);
  for (int i = 0; i < 4; ++i) {
    const std::string name = absl::StrFormat("%06d.png", i);
    EXPECT_EQ(cv::imread(pictures + "/" + name).size(), cv::Size(160, 96));
    EXPECT_EQ(Read(name + ".png").size(), cv::Size(160, 96));
  }
  EXPECT_TRUE(fs::exists(root_ + "/r/run.json"));
}

// Pictures that were taken from a video, scaled and compressed once more: the masks are those of
// their frames.
TEST_F(MasksTest, FindsPicturesInTheirVideo) {
  const PatchDriveOptions drive = SmallPatchDrive(8);
  cv::VideoWriter video(root_ + "/drive.avi", cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10.0,
                        cv::Size(160, 96));
  for (int i = 0; i < 8; ++i) video << PatchFrame(drive, i);
  video.release();
  fs::create_directories(root_ + "/images/cam0");
  const std::vector<int> taken = {1, 3, 6};
  for (size_t i = 0; i < taken.size(); ++i) {
    cv::Mat picture;
    cv::resize(PatchFrame(drive, taken[i]), picture, cv::Size(80, 48), 0, 0, cv::INTER_AREA);
    cv::imwrite(absl::StrFormat("%s/images/cam0/%c.jpg", root_, 'a' + static_cast<int>(i)),
                picture);
  }
  ASSERT_EQ(Masks({root_ + "/images", "--from_video=" + root_ + "/drive.avi", "--for=colmap"}).code,
            0);
  for (size_t i = 0; i < taken.size(); ++i) {
    const cv::Mat1b mask = Read(absl::StrFormat("cam0/%c.jpg.png", 'a' + static_cast<int>(i)));
    cv::Mat expected;
    cv::resize(cv::imread(absl::StrFormat("%s/out.run/masks/%06d.png", root_, taken[i]),
                          cv::IMREAD_GRAYSCALE),
               expected, mask.size(), 0, 0, cv::INTER_NEAREST);
    ASSERT_EQ(mask.size(), cv::Size(80, 48));
    EXPECT_EQ(cv::countNonZero((mask == 0) != (expected != 0)), 0) << i;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(out_ + "/cam0"), fs::directory_iterator()), 3);

  PatchDriveOptions other = drive;
  other.frames = 20;
  cv::imwrite(root_ + "/images/cam0/d.jpg", PatchFrame(other, 15));
  out_ = root_ + "/refused";
  const CommandOutcome refused =
      Masks({root_ + "/images", "--from_video=" + root_ + "/drive.avi", "--for=colmap"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("cam0/d.jpg: no frame of"));
  EXPECT_FALSE(fs::exists(out_));
  EXPECT_FALSE(fs::exists(out_ + ".run"));
}

// One clear line, and nothing is written.
TEST_F(MasksTest, SaysWhatIsWrong) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  const std::string path = run.folder.path();
  fs::create_directories(root_ + "/empty");
  cv::imwrite(root_ + "/small.png", cv::Mat1b(5, 5, uint8_t{255}));
  ASSERT_TRUE(
      WriteFileAtomically(root_ + "/other.json", R"({"frames": [{"file_path": "a.png"}]})").ok());
  ASSERT_TRUE(WriteFileAtomically(root_ + "/list.json", "[1, 2]").ok());
  struct Case {
    std::vector<std::string> arguments;
    int code;
    const char* message;
  };
  const std::vector<Case> cases = {
      {{path, "--for=colmap", "--also=" + root_ + "/empty"}, 3, "holds no mask of any image"},
      {{path, "--for=colmap", "--also=" + root_ + "/none"}, 3, "no such folder or picture"},
      {{path, "--for=colmap", "--also=" + root_ + "/small.png"}, 2, "5 x 5 pixels, its image 96"},
      {{path, "--for=nerfstudio"}, 3, "there is no transforms.json"},
      {{path, "--for=nerfstudio", "--transforms=" + root_ + "/none.json"}, 3, "no such file"},
      {{path, "--for=nerfstudio", "--transforms=" + root_ + "/other.json"},
       3,
       "'a.png' is no image"},
      {{path, "--for=nerfstudio", "--transforms=" + root_ + "/list.json"}, 3, "no list of frames"},
      {{path, "--for=colmap", "--transforms=" + root_ + "/other.json"}, 2, "--for=nerfstudio"},
      {{path, "--for=coco", "--invert"}, 2, "--for=plain"},
      {{path, "--for=colmap", "--threshold=1.5"}, 2, "--threshold=1.5"},
      {{path, "--for=colmap", "--threshold=0.3", "--unsure=mask"}, 2, "exclude each other"},
      {{path, "--for=colmap", "--dilate=-1"}, 2, "--dilate=-1"},
      {{path, "--for=blender"}, 2, "'blender' is none of"},
      {{path, "--for=colmap", "--run=" + root_ + "/r"}, 2, "leave --run out"},
      {{path, "--for=colmap", "--profile=fast"}, 2, "leave --profile out"},
      {{path, "--for=colmap", "--frames=" + run.frames}, 2, "lies in what is read"},
      {{path, "--for=colmap", "--truth=" + root_ + "/empty"}, 3, "no image in"},
      {{root_ + "/none", "--for=colmap"}, 3, "no such file or folder"},
      {{root_ + "/empty", "--for=colmap"}, 3, "no pictures in this folder"}};
  for (const Case& bad : cases) {
    const CommandOutcome outcome = Masks(bad.arguments);
    EXPECT_EQ(outcome.code, bad.code) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(bad.message));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
    EXPECT_FALSE(fs::exists(out_)) << bad.message;
    EXPECT_FALSE(fs::exists(out_ + ".run")) << bad.message;
  }
  EXPECT_FALSE(fs::exists(run.folder.File("masks")));
  for (const std::string& inside : {run.frames, run.frames + "/masks", path, path + "/colmap"}) {
    out_ = inside;
    const CommandOutcome outcome = Masks({path, "--for=colmap", "--overwrite"});
    EXPECT_EQ(outcome.code, 2) << inside;
    EXPECT_THAT(outcome.err, HasSubstr("--out=" + inside));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(run.frames), fs::directory_iterator()), 6);
  out_ = root_;
  EXPECT_THAT(Masks({path, "--for=colmap"}).err, HasSubstr("is or holds what is read"));
  out_ = root_ + "/small.png";
  EXPECT_THAT(Masks({path, "--for=colmap"}).err, HasSubstr("is a file"));
  fs::create_directories(root_ + "/full/x");
  out_ = root_ + "/full";
  EXPECT_THAT(Masks({path, "--for=colmap"}).err, HasSubstr("--overwrite"));
  EXPECT_EQ(Masks({path, "--for=colmap", "--overwrite"}).code, 0);
}

}  // namespace
}  // namespace egosieve::tools
