// Inputs as people have them: nested folders, masks beside pictures, chapters, turned phone video.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "tests/testing/status.h"
#include "tests/vision/frame/input_test.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(InputTest, FoldersBelowAreReadWhereTheFolderHoldsNoPictures) {
  WritePicture("cam10/1.png", 40);
  WritePicture("cam2/10.png", 30);
  WritePicture("cam2/9.png", 20);
  WritePicture(".hidden/0.png", 90);
  fs::create_directory_symlink(folder_, folder_ / "circle");
  const Seen seen = ReadAllOf(folder_.string());
  EXPECT_THAT(seen.values, ElementsAre(20, 30, 40));
  EXPECT_THAT(seen.names, ElementsAre("cam2/9.png", "cam2/10.png", "cam10/1.png"));

  WritePicture("0.png", 10);
  EXPECT_THAT(ReadAllOf(folder_.string()).names, ElementsAre("0.png"));
}

TEST_F(InputTest, NamesOfAGlobAreRelativeToTheFolderThatAllShare) {
  WritePicture("a/x/1.png", 10);
  WritePicture("a/y/1.png", 20);
  EXPECT_THAT(ReadAllOf(Path("*/*/*.png")).names, ElementsAre("x/1.png", "y/1.png"));
  EXPECT_THAT(ReadAllOf(Path("a/x/*.png")).names, ElementsAre("1.png"));
}

TEST_F(InputTest, MasksBesideThePicturesAreNoFrames) {
  const std::vector<std::vector<std::string>> kinds = {
      {"0001.jpg", "dynamic_mask_0001.png"}, {"0001.jpg", "mask_0001.png"},
      {"0001.jpg", "0001_mask.png"},         {"0001.jpg", "0001.png"},
      {"0001.jpg", "0001.jpg.png"},          {"0001.png", "0001_depth.png"},
      {"0001.jpg", "DynamicMask0001.png"},   {"images/0001.jpg", "masks/0001.jpg.png"},
      {"rgb/0001.png", "depth/0001.png"},    {"JPEGImages/0001.jpg", "Annotations/0001.png"},
      {"images/0001.jpg", "sky_masks/1.png"}};
  for (size_t i = 0; i < kinds.size(); ++i) {
    const std::string folder = std::string("k") + std::to_string(i);
    WritePicture(folder + "/" + kinds[i][0], 10);
    WritePicture(folder + "/" + kinds[i][1], 200);
    EXPECT_THAT(ReadAllOf(Path(folder)).names, ElementsAre(kinds[i][0]));
    EXPECT_THAT(RemarksOf(folder), ElementsAre(HasSubstr(kinds[i][1]))) << kinds[i][1];
  }
  EXPECT_THAT(ReadAllOf(Path("k0/*g")).names, ElementsAre("0001.jpg"));
  // Pictures of masks alone are what the user gives.
  EXPECT_THAT(ReadAllOf(Path("k7/masks")).names, ElementsAre("0001.jpg.png"));
  EXPECT_THAT(RemarksOf("k7/masks/"), ElementsAre(HasSubstr("these are masks")));
  WritePicture("unmasked/unmasked_1.png", 10);
  WritePicture("unmasked/2.png", 10);
  EXPECT_EQ(ReadAllOf(Path("unmasked")).values.size(), 2u);
}

TEST_F(InputTest, PicturesOfOtherCamerasAndSizesAreNoFrames) {
  for (const char* folder : {"data/images/", "data/images_2/", "data/images_4/", "rig/cam0/",
                             "rig/cam1/", "parts/images/", "times/1.5/", "times/2.5/"}) {
    for (const char* name : {"f_1.png", "f_2.png"}) WritePicture(std::string(folder) + name, 10);
  }
  EXPECT_THAT(ReadAllOf(Path("data")).names, ElementsAre("images/f_1.png", "images/f_2.png"));
  EXPECT_THAT(RemarksOf("data"), ElementsAre(HasSubstr("images_2 are left out as copies"),
                                             HasSubstr("images_4 are left out as copies")));
  EXPECT_THAT(ErrorOf("rig"), AllOf(HasSubstr("rig/cam0 and "), HasSubstr("several cameras")));
  EXPECT_THAT(ErrorOf("times"), HasSubstr("several cameras"));
  EXPECT_EQ(ReadAllOf(Path("rig/*/*.png")).values.size(), 4u);
  // What goes on in a further folder is one drive, and so are folders of one picture each.
  for (const char* name : {"f_3.png", "f_4.png"}) {
    WritePicture(std::string("parts/images_2/") + name, 10);
  }
  EXPECT_EQ(ReadAllOf(Path("parts")).values.size(), 4u);
  for (const char* name : {"single/1/a.png", "single/2/a.png"}) WritePicture(name, 10);
  EXPECT_EQ(ReadAllOf(Path("single")).values.size(), 2u);
  for (const char* name : {"1_left.png", "1_right.png", "2_left.png", "2_right.png"}) {
    WritePicture(std::string("stereo/") + name, 10);
  }
  EXPECT_THAT(ErrorOf("stereo"), HasSubstr("two series of files in one folder"));
  for (const char* name : {"card/1_F.avi", "card/1_R.avi", "card/2_F.avi", "card/2_R.avi"}) {
    WriteVideo(name, 1, 2, 10.0);
  }
  EXPECT_THAT(ErrorOf("card"), HasSubstr("two series of files in one folder"));
  EXPECT_EQ(ReadAllOf(Path("card/*F.avi")).values.size(), 4u);
  EXPECT_THAT(ReadAllOf(Path("stereo/*left.png")).names, ElementsAre("1_left.png", "2_left.png"));
}

TEST_F(InputTest, WhatIsPassedOverIsCounted) {
  WritePicture("day/1.jpg", 10);
  for (const char* name : {"day/2.HEIC", "day/3.HEIC", "day/4.avif", "phone/1.heic"}) {
    fs::create_directories((folder_ / name).parent_path());
    WriteText(name, std::string("\0\0\0\x18", 4) + "ftypheic0000");
  }
  WriteVideo("day/5.avi", 1, 2, 10.0);
  EXPECT_EQ(ReadAllOf(Path("day")).values.size(), 1u);
  EXPECT_THAT(RemarksOf("day"),
              ElementsAre(HasSubstr("1 AVIF files are left out; convert"),
                          HasSubstr("2 HEIC files are left out; convert"), HasSubstr("1 videos")));
  EXPECT_THAT(ErrorOf("phone"), HasSubstr("1 HEIC files are left out; convert"));
  EXPECT_THAT(ErrorOf("phone/1.heic"), HasSubstr("HEIC pictures are not read; convert"));
  fs::copy_file(Path("phone/1.heic"), Path("phone/1.jpg"));
  EXPECT_THAT(ErrorOf("phone"), HasSubstr("1.jpg: a HEIC picture"));
}

TEST_F(InputTest, LinksToFoldersAreFollowed) {
  WritePicture("elsewhere/1.png", 10);
  fs::create_directories(Path("drive"));
  fs::create_directory_symlink(folder_ / "elsewhere", folder_ / "drive" / "images");
  fs::create_directory_symlink(folder_ / "drive", folder_ / "drive" / "circle");
  EXPECT_THAT(ReadAllOf(Path("drive")).names, ElementsAre("images/1.png"));
}

TEST_F(InputTest, NamesAreAnyBytes) {
  const std::vector<std::string> names = {"$(id).png",
                                          "-dash.png",
                                          "[1].png",
                                          "a;b.png",
                                          "l\nb.png",
                                          "per%d.png",
                                          "q\".png",
                                          "stra\xdf"
                                          "e.png",
                                          "t\ta.png",
                                          "two w.png"};
  for (const std::string& name : names) WritePicture("odd [1]/" + name, 10);
  EXPECT_THAT(ReadAllOf(Path("odd [1]")).names, ElementsAreArray(names));
  EXPECT_THAT(ReadAllOf(Path("odd [1]/*.png")).names, ElementsAreArray(names));
}

TEST_F(InputTest, WhatIsNotReadSaysWhatWouldBe) {
  EXPECT_THAT(std::string(OpenFrameSource("rtsp://camera/1").status().message()),
              HasSubstr("rtsp://camera/1: a stream is read by segment alone"));
  EXPECT_THAT(std::string(OpenFrameSource("rtsp://me:secret@camera/1").status().message()),
              Not(HasSubstr("secret")));
  for (const char* name : {"drive.bag", "drive.MCAP", "drive.db3"}) {
    WriteText(name, "a recording");
    EXPECT_THAT(ErrorOf(name), HasSubstr("./run bag FILE --out=DIR"));
  }
}

TEST_F(InputTest, TheRateOfAFolderIsTheUsers) {
  for (const char* name : {"9.png", "10.png", "8.png"}) WritePicture(name, 10);
  const Seen seen = ReadAllOf(folder_.string(), {.nominal_rate_hz = 4.0});
  EXPECT_THAT(seen.names, ElementsAre("8.png", "9.png", "10.png"));
  EXPECT_THAT(seen.times, ElementsAre(0.0, 0.25, 0.5));
}

// Phones write frames at the times when there was light enough: the table of their durations has
// several entries. It is the last thing in the file but for the boxes around it, whose sizes grow.
TEST_F(InputTest, TimesOfAVideoOfVariableRateAreTheStreams) {
  cv::VideoWriter video(Path("even.mp4"), cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 10.0,
                        cv::Size(64, 32));
  for (int i = 1; i <= 4; ++i) video << cv::Mat3b(32, 64, cv::Vec3b::all(40 * i));
  video.release();
  std::ifstream in(Path("even.mp4"), std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const auto number = [&](size_t at) {
    uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
    return value;
  };
  const auto text = [](uint32_t value) {
    std::string four(4, '\0');
    for (int i = 0; i < 4; ++i) four[i] = static_cast<char>(value >> (24 - 8 * i));
    return four;
  };
  const size_t table = bytes.find("stts");
  ASSERT_NE(table, std::string::npos);
  ASSERT_GT(bytes.find("moov"), bytes.find("mdat")) << "sizes that grow would move the pictures";
  ASSERT_EQ(number(table + 8), 1u);  // entry
  const uint32_t duration = number(table + 16);
  // Three entries: 1 frame, 2 frames of three times that, 1 frame.
  bytes.replace(
      table + 8, 12,
      text(3) + text(1) + text(duration) + text(2) + text(3 * duration) + text(1) + text(duration));
  for (const char* box : {"moov", "trak", "mdia", "minf", "stbl", "stts"}) {
    const size_t at = bytes.find(box) - 4;
    bytes.replace(at, 4, text(number(at) + 16));
  }
  // The edit list ends the video where it ended before.
  if (const size_t edits = bytes.find("edts"); edits != std::string::npos) {
    bytes.replace(edits, 4, "free");
  }
  std::ofstream(Path("uneven.mp4"), std::ios::binary) << bytes;
  const Seen seen = ReadAllOf(Path("uneven.mp4"));
  ASSERT_EQ(seen.times.size(), 4u);
  EXPECT_NEAR(seen.times[1], 0.1, 1e-6);
  EXPECT_NEAR(seen.times[2], 0.4, 1e-6);
  EXPECT_NEAR(seen.times[3], 0.7, 1e-6);
}

TEST_F(InputTest, VideosOfAFolderAreChaptersOfOneDrive) {
  WriteVideo("day/clip_10.avi", 6, 3, 10.0);
  WriteVideo("day/clip_9.avi", 1, 5, 10.0);
  for (const std::string& input : {Path("day"), Path("day/*.avi")}) {
    const auto source = Value(OpenFrameSource(input));
    EXPECT_EQ(source->expected_frame_count(), 8);
    const Seen seen = ReadAll(*source);
    EXPECT_THAT(seen.values, ElementsAre(10, 20, 30, 40, 50, 60, 70, 80));
    for (int i = 0; i < 8; ++i) EXPECT_NEAR(seen.times[i], 0.1 * i, 1e-6);
    EXPECT_EQ(seen.names[7], "000007.png");
  }
  // A frame is the same however it is reached.
  const auto source = OpenFrameSource(Path("day"));
  for (const int index : {7, 2, 5, 4, 0}) {
    ASSERT_TRUE((*source)->SeekTo(index).ok());
    const absl::StatusOr<FrameRead> read = (*source)->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
    EXPECT_EQ(std::get<Frame>(*read).index, index);
    EXPECT_NEAR(std::get<Frame>(*read).image.at<cv::Vec3b>(4, 4)[0], 10 * (index + 1), 4);
    EXPECT_NEAR(std::get<Frame>(*read).time_seconds, 0.1 * index, 1e-6);
  }
  ASSERT_TRUE((*source)->SeekTo(30).ok());
  const absl::StatusOr<FrameRead> end = (*source)->Next();
  ASSERT_TRUE(end.ok() && std::holds_alternative<EndOfFrames>(*end));
  EXPECT_EQ(std::get<EndOfFrames>(*end).frame_count, 8);

  WriteText("day.txt", "day/clip_10.avi\nday/clip_9.avi\n");
  EXPECT_THAT(ReadAllOf(Path("day.txt")).values, ElementsAre(60, 70, 80, 10, 20, 30, 40, 50));
  const FrameSourceOptions options{.times = Path("day.txt")};
  EXPECT_THAT(ErrorOf("day", options), HasSubstr("no folder or glob of pictures"));
}

// A phone held upright writes pictures that lie, and a matrix in the track's header by which they
// are turned.
TEST_F(InputTest, VideoIsTurnedAsItsContainerSays) {
  cv::Mat3b picture(32, 64, cv::Vec3b::all(20));
  picture(cv::Rect(0, 0, 32, 16)).setTo(cv::Scalar::all(220));  // top left
  cv::VideoWriter video(Path("lies.mp4"), cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 10.0,
                        picture.size());
  for (int i = 0; i < 3; ++i) video << picture;
  video.release();
  std::ifstream in(Path("lies.mp4"), std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const size_t header = bytes.find("tkhd");
  ASSERT_NE(header, std::string::npos);
  // Clockwise.
  const uint8_t quarter_turn[20] = {0,    0,    0, 0, 0, 1, 0, 0, 0, 0, 0, 0,  // 0  1  0
                                    0xff, 0xff, 0, 0, 0, 0, 0, 0};             // -1 0 ...
  std::copy(std::begin(quarter_turn), std::end(quarter_turn), bytes.begin() + header + 44);
  std::ofstream(Path("turned.mp4"), std::ios::binary) << bytes;

  const auto source = Value(OpenFrameSource(Path("turned.mp4")));
  const absl::StatusOr<FrameRead> read = source->Next();
  ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
  const cv::Mat& image = std::get<Frame>(*read).image;
  ASSERT_EQ(image.size(), cv::Size(32, 64));
  EXPECT_GT(image.at<cv::Vec3b>(8, 24)[0], 180);  // what was at the top left is at the top right
  EXPECT_LT(image.at<cv::Vec3b>(8, 8)[0], 60);
  EXPECT_LT(image.at<cv::Vec3b>(56, 24)[0], 60);
}

}  // namespace
}  // namespace egosieve::vision
