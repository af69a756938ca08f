#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "tests/testing/status.h"
#include "tests/tools/masks/masks_test.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/patch_drive.h"
#include "tools/cli/command.h"
#include "tools/masks/mask_export.h"
#include "tools/masks/masks_flags.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST_F(MasksTest, TakesAThresholdWhatIsUnsureAndTheUsersOwn) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_THAT(Masks({run.folder.path(), "--for=plain", "--threshold=0.5"}), Succeeds());
  const cv::Mat1b half = Read("000003.png");
  out_ = root_ + "/unsure";
  ASSERT_THAT(Masks({run.folder.path(), "--for=plain", "--unsure=mask"}), Succeeds());
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
  ASSERT_THAT(
      Masks({run.folder.path(), "--for=plain", "--threshold=0.5", "--also=" + root_ + "/hood.png"}),
      Succeeds());
  EXPECT_EQ(Differences(Read("000003.png"), half | (own != 0)), 0);

  fs::create_directories(root_ + "/own");
  cv::imwrite(root_ + "/own/000003.png", own);
  out_ = root_ + "/also_some";
  ASSERT_THAT(
      Masks({run.folder.path(), "--for=plain", "--threshold=0.5", "--also=" + root_ + "/own"}),
      Succeeds());
  EXPECT_EQ(Differences(Read("000003.png"), half | (own != 0)), 0);
}

// From pictures in one call, folders kept, and the run is there for the next one.
TEST_F(MasksTest, SegmentsWhatIsNoRunYet) {
  WritePatchDrive(root_ + "/drive", SmallPatchDrive(6));
  fs::create_directories(root_ + "/images");
  fs::rename(root_ + "/drive/frames", root_ + "/images/cam0");
  // Pictures that shift are those of a lens of long focal length that turns.
  ASSERT_TRUE(
      WriteFileAtomically(root_ + "/cameras.txt", "1 PINHOLE 160 96 2000 2000 80 48\n").ok());
  testing::internal::CaptureStdout();
  const int code =
      Masks({root_ + "/images", "--for=colmap", "--camera=" + root_ + "/cameras.txt", "--json"})
          .code;
  const std::vector<std::string> lines =
      absl::StrSplit(testing::internal::GetCapturedStdout(), '\n', absl::SkipEmpty());
  ASSERT_EQ(code, 0);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(nlohmann::json::parse(lines[0]).at("command"), "segment");
  EXPECT_EQ(nlohmann::json::parse(lines[1]).at("command"), "refine");
  const nlohmann::json result = nlohmann::json::parse(lines[2]);
  EXPECT_EQ(result.at("images"), 6);
  int moving = 0, moving_masked = 0, rest = 0, rest_masked = 0;
  for (int i = 0; i < 6; ++i) {
    const cv::Mat1b truth =
        cv::imread(absl::StrFormat("%s/drive/masks/%06d.png", root_, i), cv::IMREAD_GRAYSCALE);
    const cv::Mat1b masked = Read(absl::StrFormat("cam0/%06d.png.png", i)) == 0;
    ASSERT_EQ(masked.size(), truth.size());
    moving += cv::countNonZero(truth == 255);
    moving_masked += cv::countNonZero((truth == 255) & masked);
    rest += cv::countNonZero(truth == 0);
    rest_masked += cv::countNonZero((truth == 0) & masked);
  }
  EXPECT_GT(moving_masked, 0.5 * moving);
  EXPECT_LT(rest_masked, 0.2 * rest);
  EXPECT_TRUE(fs::exists(out_ + ".run/masks/000005.png"));
  const std::string run = out_ + ".run";
  out_ = root_ + "/coco";
  ASSERT_THAT(Masks({run, "--for=coco"}), Succeeds());
  EXPECT_TRUE(fs::exists(out_ + "/annotations.json"));
}

// What was interrupted goes on, by the same command, and what it had made stays as it is.
TEST_F(MasksTest, GoesOnWhereItWasInterrupted) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  const std::vector<std::string> words = {run.folder.path(), "--for=colmap", "--dilate=1"};
  ASSERT_THAT(Masks(words), Succeeds());
  const std::string whole = out_;
  EXPECT_FALSE(fs::exists(whole + "/.egosieve_masks"));
  const auto interrupt = [&](const std::vector<std::string>& more, int frames) {
    MasksFlags flags;
    CLI::App app;
    flags.AddFlags(app);
    std::vector<std::string> all = {"--out=" + out_, "--progress=none"};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), more.begin(), more.end());
    std::reverse(all.begin(), all.end());
    app.parse(all);
    EXPECT_TRUE(flags.Resolve().ok());
    auto made = Value(
        MaskExport::Prepare(*OpenDriveInput(run.frames, 0), run.folder.path(), flags.options));
    const absl::Status status =
        made.Run(run.folder, *run.folder.ReadLines(), [&] { return --frames > 0; });
    EXPECT_THAT(status, IsError(absl::StatusCode::kCancelled, "the same command goes on"));
  };
  out_ = root_ + "/again";
  interrupt({}, 3);
  // No file that is whole is made again.
  const std::string kept = out_ + "/000001.png.png";
  ASSERT_TRUE(WriteFileAtomically(kept, "as it was").ok());
  EXPECT_THAT(Masks({words[0], words[1], "--dilate=2"}), Says(2, "is not empty"));
  EXPECT_THAT(Masks(words), Succeeds());
  EXPECT_EQ(*ReadFile(kept), "as it was");
  for (int i = 0; i < 6; ++i) {
    const std::string name = absl::StrFormat("/%06d.png.png", i);
    if (i == 1) continue;
    EXPECT_EQ(*ReadFile(out_ + name), *ReadFile(whole + name)) << name;
  }
  EXPECT_FALSE(fs::exists(out_ + "/.egosieve_masks"));
  EXPECT_EQ(Masks(words).code, 2) << "a whole export is not continued";
  // Files of a former export are none of the interrupted one.
  interrupt({"--overwrite"}, 1);
  EXPECT_THAT(Masks(words), Succeeds());
  EXPECT_EQ(*ReadFile(kept), *ReadFile(whole + "/000001.png.png"));
  // Of a run that was made anew meanwhile.
  fs::remove_all(out_);
  interrupt({}, 3);
  ASSERT_TRUE(WriteFileAtomically(kept, "of the former run").ok());
  RunDescription description = run.description;
  description.finished_utc = "2031-01-01T00:00:00Z";
  ASSERT_TRUE(run.folder.WriteDescription(description).ok());
  EXPECT_THAT(Masks(words), Succeeds());
  EXPECT_EQ(*ReadFile(kept), *ReadFile(whole + "/000001.png.png"));
}

// Lists may name pictures anywhere: their masks lie in --out, and no picture is written over.
TEST_F(MasksTest, StaysInItsFolderWhateverAListNames) {
  WritePatchDrive(root_ + "/drive", SmallPatchDrive(6));
  const std::string lists = root_ + "/project/lists";
  fs::create_directories(lists);
  fs::create_directories(root_ + "/project/images");
  fs::create_directories(lists + "/own");  // so that the others lie above what all share
  fs::copy(root_ + "/drive/frames/000000.png", lists + "/own/000000.png");
  std::string text = "own/000000.png\n";
  for (int i = 0; i < 6; ++i) {
    const std::string name = absl::StrFormat("%06d.png", i);
    fs::copy(root_ + "/drive/frames/" + name, root_ + "/project/images/" + name);
    if (i > 0) absl::StrAppend(&text, "../images/", name, "\n");
  }
  std::ofstream(lists + "/all.txt") << text;
  const std::string picture = *ReadFile(root_ + "/project/images/000003.png");
  // Beside the pictures' folder, as one level up from a mask "../images/000003.png" would be.
  out_ = root_ + "/project/masks";
  for (const char* format : {"plain", "colmap", "instant-ngp", "gaussian-splatting"}) {
    EXPECT_THAT(Masks({lists + "/all.txt", absl::StrCat("--for=", format), "--overwrite",
                       "--frames=" + root_ + "/project/copies", "--run=" + root_ + "/run"}),
                Succeeds());
    EXPECT_EQ(*ReadFile(root_ + "/project/images/000003.png"), picture) << format;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(root_ + "/project/images"), {}), 6);
  EXPECT_TRUE(fs::exists(out_ + "/images/000003.png.png"));
  EXPECT_TRUE(fs::exists(out_ + "/images/dynamic_mask_000003.png"));
  EXPECT_EQ(*ReadFile(root_ + "/project/copies/images/000003.png"), picture);

  // Two pictures of one name, in folders of their own.
  fs::create_directories(root_ + "/images");
  fs::copy(root_ + "/drive/frames/000000.png", root_ + "/images/000000.png");
  std::ofstream(lists + "/twins.txt") << "../images/000000.png\n../../images/000000.png\n";
  out_ = root_ + "/twins";
  EXPECT_EQ(Masks({lists + "/twins.txt", "--for=colmap", "--run=" + root_ + "/other"}).code, 4);
  EXPECT_TRUE(fs::exists(out_ + "/images/000000.png.png"));
  EXPECT_TRUE(fs::exists(out_ + "/project/images/000000.png.png"));

  // A link in --out that leads to the pictures.
  fs::create_directories(root_ + "/linked");
  fs::create_directory_symlink(root_ + "/project/images", root_ + "/linked/images");
  out_ = root_ + "/linked";
  EXPECT_THAT(Masks({lists + "/all.txt", "--for=plain", "--overwrite", "--run=" + root_ + "/run"}),
              Says(2, "leads out of --out"));
  EXPECT_EQ(*ReadFile(root_ + "/project/images/000003.png"), picture);
}

TEST_F(MasksTest, PicturesWhoseMasksWouldBeOneFileAreRefused) {
  fs::create_directories(root_ + "/twins");
  for (const char* name : {"a.jpg", "a.jpeg"}) {
    ASSERT_TRUE(cv::imwrite(root_ + "/twins/" + name, cv::Mat3b(48, 64, cv::Vec3b(9, 9, 9))));
  }
  EXPECT_THAT(Masks({root_ + "/twins", "--for=instant-ngp", "--run=" + root_ + "/other"}),
              Says(2, "/dynamic_mask_a.png, of the pictures"));
  EXPECT_FALSE(fs::exists(out_));
  EXPECT_FALSE(fs::exists(root_ + "/other"));
}

TEST(NameInside, LeavesNothingThatLeadsOut) {
  EXPECT_EQ(NameInside("a/b.png"), "a/b.png");
  EXPECT_EQ(NameInside("../../images/./x/../1.png"), "images/1.png");
  EXPECT_EQ(NameInside("/data/1.png"), "data/1.png");
  EXPECT_EQ(NameInside("a/../../../b.png"), "b.png");
}

// DAVIS has no number above 254, MOTS none above 999: known before the first file.
TEST_F(MasksTest, MoversThatTheFormatCannotNumberAreToldBeforeAnythingIsWritten) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_THAT(Masks({run.folder.path(), "--for=davis"}), Succeeds());
  cv::Mat1w ids = Made(run, "ids", 5);
  for (const auto& [format, most] : {std::pair{"davis", 254}, {"mots", 999}}) {
    for (const int number : {most, most + 1}) {
      out_ = root_ + absl::StrFormat("/%s_%d", format, number);
      ids(7, 9) = static_cast<uint16_t>(number);
      cv::imwrite(run.folder.FrameFile("ids", 5, ".png"), ids);
      const CommandOutcome outcome = Masks({run.folder.path(), absl::StrCat("--for=", format)});
      EXPECT_EQ(outcome.code, number == most ? 0 : 2) << outcome.err;
      EXPECT_EQ(fs::exists(out_), number == most);
      if (number == most) continue;
      EXPECT_THAT(outcome.err, HasSubstr(absl::StrFormat("frame 5: mover %d", number)));
    }
  }
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
  WritePatchVideo(root_ + "/drive.avi", SmallPatchDrive(4), 4);
  const std::string pictures = root_ + "/pictures";
  ASSERT_THAT(Masks({root_ + "/drive.avi", "--for=colmap", "--frames=" + pictures,
                     "--run=" + root_ + "/r"}),
              Succeeds());
  for (int i = 0; i < 4; ++i) {
    const std::string name = absl::StrFormat("%06d.png", i);
    EXPECT_EQ(cv::imread(pictures + "/" + name).size(), cv::Size(160, 96));
    EXPECT_EQ(Read(name + ".png").size(), cv::Size(160, 96));
  }
  EXPECT_TRUE(fs::exists(root_ + "/r/run.json"));

  // Fewer frames than the run holds by now.
  out_ = root_ + "/again";
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  const int code = Masks({root_ + "/drive.avi", "--for=colmap", "--max_frames=2",
                          "--frames=" + pictures, "--overwrite", "--run=" + root_ + "/r"})
                       .code;
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              HasSubstr("--image_path=" + pictures + " --ImageReader.mask_path=" + out_));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("goes on to frame 3 already"));
  EXPECT_EQ(code, 0);
  EXPECT_TRUE(fs::exists(out_ + "/000003.png.png"));
}

// Pictures that were taken from a video, scaled and compressed once more: the masks are those of
// their frames.
TEST_F(MasksTest, FindsPicturesInTheirVideo) {
  const PatchDriveOptions drive = SmallPatchDrive(8);
  WritePatchVideo(root_ + "/drive.avi", drive, 8);
  fs::create_directories(root_ + "/images/cam0");
  const std::vector<int> taken = {1, 3, 6};
  for (size_t i = 0; i < taken.size(); ++i) {
    cv::Mat picture;
    cv::resize(PatchFrame(drive, taken[i]), picture, cv::Size(80, 48), 0, 0, cv::INTER_AREA);
    cv::imwrite(absl::StrFormat("%s/images/cam0/%c.jpg", root_, 'a' + static_cast<int>(i)),
                picture);
  }
  ASSERT_THAT(Masks({root_ + "/images", "--from_video=" + root_ + "/drive.avi", "--for=colmap"}),
              Succeeds());
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
  EXPECT_THAT(Masks({root_ + "/images", "--from_video=" + root_ + "/drive.avi", "--for=colmap"}),
              Says(2, "cam0/d.jpg: no frame of"));
  EXPECT_FALSE(fs::exists(out_));
  EXPECT_FALSE(fs::exists(out_ + ".run"));
}

// One clear line, and nothing is written.
TEST_F(MasksTest, SaysWhatIsWrong) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  const std::string path = run.folder.path();
  for (const char* name : {"/empty", "/foreign"}) fs::create_directories(root_ + name);
  cv::imwrite(root_ + "/foreign/other.png", cv::Mat1b(64, 96, uint8_t{255}));
  std::ofstream(root_ + "/none.txt") << "# nothing\n";
  std::ofstream(root_ + "/missing.txt") << run.frames << "/absent.png\n";
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
      {{path, "--for=colmap", "--also=" + root_ + "/foreign"}, 3, "holds no mask of any image"},
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
      {{run.frames, "--for=colmap", "--input=" + run.frames}, 2, "is no run folder"},
      {{path, "--for=colmap", "--threshold=1.5"}, 2, "--threshold=1.5"},
      {{path, "--for=colmap", "--threshold=0.3", "--unsure=mask"}, 2, "exclude each other"},
      {{path, "--for=colmap", "--dilate=-1"}, 2, "--dilate=-1"},
      {{path, "--for=blender"}, 2, "'blender' is none of"},
      {{path, "--for=colmap", "--run=" + root_ + "/r"}, 2, "leave --run out"},
      {{path, "--for=colmap", "--profile=fast"}, 2, "leave --profile out"},
      {{path, "--for=colmap", "--frames=" + run.frames}, 2, "lies in what is read"},
      {{run.frames, "--for=colmap", "--run=" + out_}, 2, "lies in what is read"},
      {{run.frames, "--for=colmap", "--run=" + run.frames + "/r"}, 2, "name another by --run"},
      {{root_ + "/none.txt", "--for=colmap"}, 3, "the list names no picture"},
      {{root_ + "/missing.txt", "--for=colmap"}, 3, "line 1: no such file"},
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
}

TEST_F(MasksTest, TellsColmapWhereThePicturesAre) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  testing::internal::CaptureStdout();
  EXPECT_THAT(Masks({run.folder.path(), "--for=colmap"}), Succeeds());
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("--image_path=" + run.frames));
}

TEST_F(MasksTest, WritesIntoNoFolderThatIsReadOrSomebodyElses) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  const std::string path = run.folder.path();
  for (const std::string& inside : {run.frames, run.frames + "/masks", path, path + "/colmap"}) {
    out_ = inside;
    EXPECT_THAT(Masks({path, "--for=colmap", "--overwrite"}), Says(2, "--out=" + inside)) << inside;
  }
  out_ = run.frames + "/masks";
  EXPECT_THAT(Masks({run.frames + "/*.png", "--for=colmap"}).err,
              HasSubstr("--out=" + out_ + " lies in what is read"));
  EXPECT_EQ(std::distance(fs::directory_iterator(run.frames), fs::directory_iterator()), 6);
  out_ = root_;
  EXPECT_THAT(Masks({path, "--for=colmap"}).err, HasSubstr("is or holds what is read"));
  out_ = root_ + "/a.png";
  ASSERT_TRUE(WriteFileAtomically(out_, "").ok());
  EXPECT_THAT(Masks({path, "--for=colmap"}).err, HasSubstr("is a file"));
  fs::create_directories(root_ + "/full/x");
  out_ = root_ + "/full";
  EXPECT_THAT(Masks({path, "--for=colmap"}).err, HasSubstr("--overwrite"));
  EXPECT_THAT(Masks({path, "--for=colmap", "--overwrite"}), Succeeds());
}

}  // namespace
}  // namespace egosieve::tools
