// The bytes of each format, by its reader's rules.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "tests/tools/masks/masks_test.h"
#include "tests/tools/testing/outcome.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

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

// Every image has a mask of its name with .png behind it; COLMAP leaves out where it is 0.
TEST_F(MasksTest, OfColmap) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_THAT(Masks({run.folder.path(), "--for=colmap"}), Succeeds());
  for (int i = 0; i < 6; ++i) {
    const cv::Mat mask = Read(absl::StrFormat("%06d.png.png", i));
    EXPECT_EQ(Differences(mask, Made(run, "masks", i) == 0), 0) << i;
  }
  EXPECT_GT(cv::countNonZero(Read("000003.png.png") == 0), 100);
  EXPECT_EQ(std::distance(fs::directory_iterator(out_), fs::directory_iterator()), 6);

  out_ = root_ + "/grown";
  ASSERT_THAT(Masks({run.folder.path(), "--for=colmap", "--dilate=4", "--invert"}), Succeeds());
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
  ASSERT_THAT(Masks({run.folder.path(), "--for=nerfstudio"}), Succeeds());
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

// By nerfstudio's rule (`_get_fname` of its parser): images_N and masks_N in the folder of
// transforms.json, the files' names without folders, and sizes that ffmpeg rounds down.
TEST_F(MasksTest, OfNerfstudioWithReducedPictures) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  nlohmann::json transforms;
  for (int i = 0; i < 6; ++i) {
    transforms["frames"].push_back({{"file_path", absl::StrFormat("frames/%06d.png", i)}});
  }
  ASSERT_TRUE(WriteFileAtomically(root_ + "/drive/transforms.json", transforms.dump()).ok());
  for (const char* folder : {"images_2", "images_8", "images_x"}) {
    fs::create_directory(root_ + "/drive/" + folder);
  }
  cv::imwrite(root_ + "/drive/images_2/000003.png", cv::Mat3b(4, 4));
  for (const char* again : {"--dilate=0", "--overwrite"}) {
    ASSERT_THAT(Masks({run.folder.path(), "--for=nerfstudio", again}), Succeeds());
  }
  EXPECT_TRUE(fs::exists(out_ + "/images_2/000003.png"));
  EXPECT_FALSE(fs::exists(out_ + "/images_x"));
  const cv::Mat1b moving = Made(run, "masks", 3);
  for (const int by : {2, 8}) {
    const cv::Mat1b mask = Read(absl::StrFormat("masks_%d/000003.png.png", by));
    ASSERT_EQ(mask.size(), cv::Size(moving.cols / by, moving.rows / by));
    for (int y = 0; y < mask.rows; ++y) {
      for (int x = 0; x < mask.cols; ++x) {
        const bool is_used = cv::countNonZero(moving(cv::Rect(x * by, y * by, by, by))) == 0;
        ASSERT_EQ(mask(y, x), is_used ? 255 : 0) << x << ", " << y << " of " << by;
      }
    }
  }
}

// As programs on Windows and instant-ngp's converter write them.
TEST_F(MasksTest, OfNerfstudioWithBackslashesAndWithoutExtensions) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  for (const char* form : {"frames\\%06d.png", ".\\frames\\%06d", "./frames/%06d"}) {
    nlohmann::json transforms;
    for (int i = 0; i < 6; ++i) {
      const auto format = absl::ParsedFormat<'d'>::New(form);
      transforms["frames"].push_back({{"file_path", absl::StrFormat(*format, i)}});
    }
    ASSERT_TRUE(WriteFileAtomically(root_ + "/drive/transforms.json", transforms.dump()).ok());
    ASSERT_THAT(Masks({run.folder.path(), "--for=nerfstudio", "--overwrite"}), Succeeds()) << form;
    const nlohmann::json copy = nlohmann::json::parse(*ReadFile(out_ + "/transforms.json"));
    ASSERT_EQ(copy.at("frames").size(), 6u);
    for (int i = 0; i < 6; ++i) {
      const nlohmann::json& frame = copy.at("frames")[i];
      EXPECT_EQ(frame.at("file_path"), absl::StrFormat("../drive/frames/%06d.png", i));
      EXPECT_EQ(Differences(Read(frame.at("mask_path")), Made(run, "masks", i) == 0), 0);
    }
  }
}

TEST_F(MasksTest, OfInstantNgpWithPictures) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_THAT(Masks({run.folder.path(), "--for=instant-ngp", "--frames=" + out_}), Succeeds());
  EXPECT_EQ(Differences(Read("dynamic_mask_000003.png"), Made(run, "masks", 3)), 0);
  EXPECT_EQ(*ReadFile(out_ + "/000003.png"), *ReadFile(run.frames + "/000003.png"));
}

// By the programs' manual or source (docs/masks-recipes.md): the names, and which side is ignored.
TEST_F(MasksTest, OfProgramsThatFindMasksByName) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  fs::rename(run.frames, root_ + "/cam0");
  fs::create_directories(run.frames);
  fs::rename(root_ + "/cam0", run.frames + "/cam0");
  struct Case {
    const char* format;
    const char* file;
    bool is_white;
  };
  for (const Case& each :
       {Case{"opensfm", "cam0/000003.png.png", false}, Case{"lichtfeld", "cam0/000003.png", false},
        Case{"postshot", "cam0/000003.png", true}, Case{"metashape", "cam0/000003_mask.png", false},
        Case{"realityscan", "cam0/000003.png.mask.png", false}}) {
    out_ = root_ + "/" + each.format;
    ASSERT_THAT(Masks({run.folder.path(), std::string("--for=") + each.format}), Succeeds());
    const cv::Mat mask = Read(each.file);
    ASSERT_EQ(mask.type(), CV_8UC1) << each.format;
    const cv::Mat1b moving = Made(run, "masks", 3);
    EXPECT_GT(cv::countNonZero(moving), 100);
    EXPECT_EQ(Differences(mask == (each.is_white ? 255 : 0), moving), 0) << each.format;
  }
}

TEST_F(MasksTest, OfGaussianSplatting) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_THAT(Masks({run.folder.path(), "--for=gaussian-splatting"}), Succeeds());
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
  ASSERT_THAT(Masks({run.folder.path(), "--for=davis"}), Succeeds());
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

TEST_F(MasksTest, OfPicturesWhoseNamesAreNotUtf8) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  fs::rename(run.frames + "/000005.png", run.frames + "/000005\xdf.png");
  ASSERT_THAT(Masks({run.folder.path(), "--for=colmap"}), Succeeds());
  EXPECT_EQ(Differences(Read("000005\xdf.png.png"), Made(run, "masks", 5) == 0), 0);
  out_ = root_ + "/coco";
  ASSERT_THAT(Masks({run.folder.path(), "--for=coco"}), Succeeds());
  const nlohmann::json json = nlohmann::json::parse(*ReadFile(out_ + "/annotations.json"));
  EXPECT_EQ(json.at("images")[5].at("file_name"), "000005%DF.png");

  out_ = root_ + "/long";
  fs::rename(run.frames + "/000005\xdf.png",
             run.frames + "/000005" + std::string(240, 'n') + ".png");
  EXPECT_THAT(Masks({run.folder.path(), "--for=instant-ngp"}), Says(2, "more than 255 bytes"));
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(MasksTest, OfCoco) {
  const FakeRun run = WriteFakeRun(root_ + "/drive");
  ASSERT_THAT(Masks({run.folder.path(), "--for=coco"}), Succeeds());
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
  ASSERT_THAT(Masks({run.folder.path(), "--for=mots"}), Succeeds());
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

}  // namespace
}  // namespace egosieve::tools
