#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <variant>
#include <vector>

#include "tests/testing/status.h"
#include "tests/vision/frame/input_test.h"
#include "vision/frame/equalization.h"
#include "vision/frame/file_list.h"
#include "vision/frame/frame_source.h"
#include "vision/frame/image_decoding.h"

namespace egosieve::vision {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
namespace fs = std::filesystem;
using ::testing::HasSubstr;

using ImageDecodingTest = FolderTest;

// A number of `size` bytes, the highest first.
std::string BigEndian(int64_t value, int size) {
  std::string bytes;
  for (int i = size - 1; i >= 0; --i) bytes.push_back(static_cast<char>(value >> (8 * i)));
  return bytes;
}

TEST_F(ImageDecodingTest, EveryPixelFormatBecomesEightBitBgr) {
  WriteImage("0.png", Solid(CV_8UC1, cv::Scalar(7)));
  WriteImage("1.png", Solid(CV_16UC1, cv::Scalar(257 * 200)));
  WriteImage("2.png", Solid(CV_16UC3, cv::Scalar(257 * 1, 257 * 2, 257 * 3)));
  WriteImage("3.png", Solid(CV_8UC4, cv::Scalar(1, 2, 3, 0)));
  WriteImage("4.png", Solid(CV_16UC4, cv::Scalar(257, 514, 771, 65535)));
  auto source = Value(OpenFrameSource(Path("*.png")));
  const cv::Vec3b expected[] = {{7, 7, 7}, {200, 200, 200}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}};
  for (int index = 0; index < 5; ++index) {
    const auto read = source->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read)) << index;
    const Frame& frame = std::get<Frame>(*read);
    ASSERT_EQ(frame.image.type(), CV_8UC3) << index;
    EXPECT_EQ(frame.image.at<cv::Vec3b>(3, 3), expected[index]) << index;
    EXPECT_EQ(frame.is_grey, index < 2) << index;
  }
}

TEST_F(ImageDecodingTest, DamagedPicturesAreReportedAndSkipped) {
  cv::Mat noise(64, 64, CV_8UC3);
  cv::theRNG().state = 1;
  cv::randu(noise, 0, 255);
  for (const char* name : {"0.png", "1.png", "2.jpg", "4.png"}) WriteImage(name, noise);
  fs::resize_file(Path("1.png"), fs::file_size(Path("1.png")) / 2);
  fs::resize_file(Path("2.jpg"), fs::file_size(Path("2.jpg")) / 2);
  WriteText("3.png", "");
  auto source = Value(OpenFrameSource(folder_.string()));
  for (int index = 0; index < 5; ++index) {
    const auto read = Value(source->Next());
    if (index == 0 || index == 4) {
      ASSERT_TRUE(std::holds_alternative<Frame>(read)) << index;
      EXPECT_EQ(std::get<Frame>(read).index, index);
    } else {
      ASSERT_TRUE(std::holds_alternative<DamagedFrame>(read)) << index;
      EXPECT_EQ(std::get<DamagedFrame>(read).index, index);
      EXPECT_THAT(std::get<DamagedFrame>(read).reason, HasSubstr(std::to_string(index) + "."));
    }
  }
}

// The decoder tells whether a JPEG is whole, not a marker somewhere in the file.
TEST_F(ImageDecodingTest, WholeJpegsAreReadWhateverLiesBehindThem) {
  cv::Mat noise(256, 256, CV_8UC3);
  cv::theRNG().state = 1;
  cv::randu(noise, 0, 255);
  std::vector<uint8_t> encoded;
  cv::imencode(".jpg", noise, encoded);
  const std::string whole(encoded.begin(), encoded.end());
  const std::string end = "\xff\xd9", half = whole.substr(0, whole.size() / 2);
  ASSERT_TRUE(whole.ends_with(end));
  const std::string video = "MotionPhoto_Data" + std::string(20000, 'v');
  std::string broken = whole;
  for (size_t i = whole.size() / 2; i < whole.size() / 2 + 40; ++i) broken[i] = '\xfe';
  const std::vector<std::string> read = {whole, whole + video, whole + std::string(9000, '\0'),
                                         whole.substr(0, whole.size() - 2)};
  const std::vector<std::string> refused = {half,
                                            half + end,
                                            half + video + end,
                                            half + std::string(half.size(), '\0'),
                                            whole.substr(0, 300),
                                            broken};
  const cv::Mat decoded = cv::imdecode(encoded, cv::IMREAD_COLOR);
  for (const std::string& bytes : read) {
    WriteText("a.jpg", bytes);
    const auto source = Value(OpenFrameSource(Path("a.jpg")));
    const auto frame = source->Next();
    ASSERT_TRUE(frame.ok() && std::holds_alternative<Frame>(*frame));
    EXPECT_EQ(cv::norm(std::get<Frame>(*frame).image, decoded, cv::NORM_INF), 0.0);
  }
  for (size_t i = 0; i < refused.size(); ++i) {
    WriteText("a.jpg", refused[i]);
    EXPECT_THAT(MessageOf(OpenFrameSource(Path("a.jpg")).status()),
                HasSubstr("a.jpg: the picture is cut short"))
        << i;
  }
}

TEST_F(ImageDecodingTest, WholePngsAreReadWhateverLiesBehindThem) {
  std::vector<uint8_t> encoded;
  cv::imencode(".png", Solid(CV_8UC3, cv::Scalar(1, 2, 3)), encoded);
  const std::string whole(encoded.begin(), encoded.end());
  WriteText("a.png", whole + std::string(9000, 'x'));
  EXPECT_TRUE(OpenFrameSource(Path("a.png")).ok());
  WriteText("a.png", whole.substr(0, whole.size() - 20) + "IEND");
  EXPECT_THAT(MessageOf(OpenFrameSource(Path("a.png")).status()), HasSubstr("cut short"));
}

// Counts of a thermal camera, 12 bits of a machine camera, and floats in other units.
TEST_F(ImageDecodingTest, ValuesOfAPartOfTheirRangeAreStretchedAlikeInAllFrames) {
  struct Kind {
    const char* name;
    int depth;
    double zero, step;  // of the level k = 0 .. 255: zero + step k
  };
  for (const Kind& kind : {Kind{"thermal", CV_16U, 7800, 5}, Kind{"twelve", CV_16U, 8, 16},
                           Kind{"kelvin", CV_32F, 280, 0.1}, Kind{"full", CV_16U, 0, 257}}) {
    fs::create_directories(Path(kind.name));
    // Frame 0 has dark levels alone, frame 1 all, and each has a hot pixel.
    for (const int most : {127, 255}) {
      cv::Mat1d level(64, 64);
      for (int i = 0; i < 64 * 64; ++i) level(i / 64, i % 64) = i * (most + 1) / (64 * 64);
      cv::Mat stored = level * kind.step + kind.zero;
      if (kind.step != 257) stored.at<double>(40, 40) = 60000;
      stored.convertTo(stored, kind.depth);
      WriteImage(std::string(kind.name) + "/" + std::to_string(most) + ".tiff", stored);
    }
    const auto source = Value(OpenFrameSource(Path(kind.name)));
    const bool is_full = kind.step == 257;
    EXPECT_EQ(source->remarks().size(), is_full ? 0u : 1u) << kind.name;
    for (const int most : {255, 127}) {  // "127.tiff" is the first
      ASSERT_TRUE(source->SeekTo(most == 127 ? 0 : 1).ok());
      const auto read = source->Next();
      ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
      const cv::Mat& image = std::get<Frame>(*read).image;
      for (const int i : {0, 1000, 2000, 4095}) {
        EXPECT_NEAR(image.at<cv::Vec3b>(i / 64, i % 64)[1], i * (most + 1) / (64 * 64),
                    is_full ? 0 : 2)
            << kind.name << " " << most << " " << i;
      }
    }
  }
}

// GDCM, a decoder behind OpenCV, ends the process on these bytes.
TEST_F(ImageDecodingTest, WhatIsNoPictureReachesNoOtherDecoder) {
  const std::string dicom =
      std::string(128, '\0') + "DICM" + std::string("\0\0\xff\xd8SVD\xae\x42\x60\x82", 11);
  std::ofstream(Path("dicom.png"), std::ios::binary) << dicom;
  EXPECT_THAT(std::string(OpenFrameSource(Path("dicom.png")).status().message()),
              HasSubstr("cannot be decoded as a picture"));
}

TEST(PixelLimit, TakesWhatCamerasGive) {
  EXPECT_TRUE(CheckPixels(7680, 4320).ok());
  EXPECT_TRUE(CheckPixels(15360, 8640).ok());
  EXPECT_FALSE(CheckPixels(30000, 30000).ok());
  EXPECT_FALSE(CheckPixels(int64_t{1} << 32, int64_t{1} << 32).ok());
}

// A few bytes may say that gigabytes follow: refused before anything is decoded.
TEST_F(ImageDecodingTest, PicturesOfTooManyPixelsAreRefusedByTheirHeader) {
  std::vector<uint8_t> png, jpeg;
  cv::imencode(".png", Solid(CV_8UC1, 9), png);
  cv::imencode(".jpg", Solid(CV_8UC3, 9), jpeg);
  const std::string side = BigEndian(30000, 4), half = BigEndian(30000, 2);
  std::copy(side.begin(), side.end(), png.begin() + 16);
  std::copy(side.begin(), side.end(), png.begin() + 20);
  const std::string frame_header = "\xff\xc0";
  const auto sof = std::search(jpeg.begin(), jpeg.end(), frame_header.begin(), frame_header.end(),
                               [](uint8_t a, char b) { return a == static_cast<uint8_t>(b); });
  ASSERT_NE(sof, jpeg.end());
  std::copy(half.begin(), half.end(), sof + 5);
  std::copy(half.begin(), half.end(), sof + 7);
  WriteText("big.png", std::string(png.begin(), png.end()));
  WriteText("big.jpg", std::string(jpeg.begin(), jpeg.end()));
  for (const char* name : {"big.png", "big.jpg"}) {
    const auto source = OpenFrameSource(Path(name));
    ASSERT_FALSE(source.ok()) << name;
    EXPECT_THAT(MessageOf(source.status()), HasSubstr("30000 x 30000 pixels are more than"));
    EXPECT_THAT(MessageOf(source.status()), HasSubstr(name));
  }
}

// A dark picture: luminance between 10 and 60, blue twice red.
cv::Mat DarkPicture() {
  cv::Mat image(64, 96, CV_8UC3);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const int v = 10 + (x + y) % 40;
      image.at<cv::Vec3b>(y, x) = cv::Vec3b(2 * v, v, v);
    }
  }
  return image;
}

double LuminanceRange(const cv::Mat& image) {
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  double low, high;
  cv::minMaxLoc(grey, &low, &high);
  return high - low;
}

TEST(EqualizeLuminance, NoneReturnsTheSamePixels) {
  const cv::Mat image = DarkPicture();
  EXPECT_EQ(cv::norm(EqualizeLuminance(image, {}), image, cv::NORM_INF), 0.0);
}

TEST(EqualizeLuminance, OpensDarkPicturesAndLeavesTheInputAlone) {
  const cv::Mat image = DarkPicture();
  const cv::Mat before = image.clone();
  for (const Equalization method : {Equalization::kGlobal, Equalization::kClahe}) {
    const cv::Mat result = EqualizeLuminance(image, method);
    ASSERT_EQ(result.type(), CV_8UC3);
    EXPECT_GT(LuminanceRange(result), 1.5 * LuminanceRange(image));
    EXPECT_EQ(cv::norm(image, before, cv::NORM_INF), 0.0);
  }
}

// Adding a constant shifts the histogram and leaves its shape: equalisation must undo it.
TEST(EqualizeLuminance, GlobalTakesOutAChangeOfLight) {
  constexpr Equalization kMethod = Equalization::kGlobal;
  cv::Mat grey;
  cv::cvtColor(DarkPicture(), grey, cv::COLOR_BGR2GRAY);
  const cv::Mat brighter = grey + 50;
  EXPECT_EQ(cv::norm(EqualizeLuminance(grey, kMethod), EqualizeLuminance(brighter, kMethod),
                     cv::NORM_INF),
            0.0);
}

class FileListTest : public InputTest {};

TEST_F(FileListTest, ListsGiveOrderAndTimes) {
  WritePicture("rgb/b.png", 10);
  WritePicture("rgb/a.png", 20);
  WriteText("rgb.txt",
            "# color images\n# timestamp filename\n1305031102.175304 rgb/b.png\n\n"
            "1305031102.211214 rgb/a.png\n");
  const Seen tum = ReadAllOf(Path("rgb.txt"));
  EXPECT_THAT(tum.values, ElementsAre(10, 20));
  EXPECT_THAT(tum.times, ElementsAre(1305031102.175304, 1305031102.211214));

  WritePicture("cam0/data/140.png", 30);
  WritePicture("cam0/data/141.png", 40);
  WriteText("cam0/data.csv",
            "#timestamp [ns],filename\r\n1403636579763555584,140.png\r\n"
            "1403636579813555456,141.png\r\n");
  const Seen euroc = ReadAllOf(Path("cam0/data.csv"));
  EXPECT_THAT(euroc.names, ElementsAre("140.png", "141.png"));
  EXPECT_NEAR(euroc.times[1] - euroc.times[0], 0.049999872, 1e-6);

  WriteText("names.csv", "file,time\nrgb/a.png,0.5\nrgb/b.png,0.7\n");
  EXPECT_THAT(ReadAllOf(Path("names.csv")).times, ElementsAre(0.5, 0.7));
  WriteText("bare.txt", "rgb/a.png\nrgb/b.png\n");
  EXPECT_THAT(ReadAllOf(Path("bare.txt")).times, ElementsAre(0.0, 0.1));
}

TEST_F(FileListTest, TimesOfAFolderComeFromAFile) {
  WritePicture("image_2/0.png", 10);
  WritePicture("image_2/1.png", 20);
  WriteText("times.txt", "0.000000e+00\n1.036220e-01\n");
  FrameSourceOptions options{.times = Path("times.txt")};
  EXPECT_THAT(ReadAllOf(Path("image_2"), options).times, ElementsAre(0.0, 0.103622));
  WriteText("times.txt", "2011-09-26 13:02:25.25\n2011-09-26 13:02:25.5\n");
  const Seen raw = ReadAllOf(Path("image_2"), options);
  EXPECT_NEAR(raw.times[1] - raw.times[0], 0.25, 1e-6);

  WriteText("times.txt", "0\n");
  EXPECT_THAT(ErrorOf("image_2", options), HasSubstr("has 1 times for 2 pictures"));
  WriteText("times.txt", "0.5\n0.5\n");
  EXPECT_THAT(ErrorOf("image_2", options), HasSubstr("line 2: the time 0.5 is equal to the one"));
  WriteText("times.txt", "0.5\n0.25\n");
  EXPECT_THAT(ErrorOf("image_2", options), HasSubstr("line 2: the time 0.25 does not come after"));
  WriteText("times.txt", "0.5\nsoon\n");
  EXPECT_THAT(ErrorOf("image_2", options), HasSubstr("line 2: 'soon' is no time"));
  options.times = Path("none.txt");
  EXPECT_THAT(ErrorOf("image_2", options), HasSubstr("none.txt"));
}

TEST_F(FileListTest, ListsSayWhatIsWrongWithThem) {
  WritePicture("a.png", 10);
  WritePicture("b.png", 10);
  const auto error = [&](const std::string& text) {
    WriteText("list.txt", text);
    return ErrorOf("list.txt");
  };
  EXPECT_THAT(error("# nothing\n\n"), HasSubstr("the list names no picture"));
  EXPECT_THAT(error("0.1 a.png\n0.2 c.png\n"), HasSubstr("line 2: no such file"));
  EXPECT_THAT(error("0.2 a.png\n0.1 b.png\n"), HasSubstr("line 2: the time 0.1 does not come"));
  EXPECT_THAT(error("0.2 a.png\nb.png\n"), HasSubstr("line 2: some lines have a time"));
  EXPECT_THAT(error("a.png\n0.2 b.png\n"), HasSubstr("line 2: some lines have a time"));
  EXPECT_THAT(error("0.0\n0.1\n"), HasSubstr("line 1: a time without a picture"));
  EXPECT_THAT(error("0.1,a.png\nx,y\n"), HasSubstr("line 2: neither"));
}

// As programs write them: marks of Windows, quotes, further columns, names like numbers.
TEST_F(FileListTest, ListsAreReadAsTheyAreWritten) {
  WritePicture("rgb/1.5.png", 10);
  WritePicture("rgb/2.5.png", 20);
  WritePicture("depth/1.5.png", 90);
  WritePicture("depth/2.5.png", 90);
  const std::vector<std::string> timed = {
      "\xef\xbb\xbf"
      "1.5 rgb/1.5.png\r\n2.5 rgb/2.5.png\r\n",
      "\xef\xbb\xbf"
      "1.5,rgb/1.5.png\r\n2.5,rgb/2.5.png\r\n",
      "timestamp,filename\n\"1.5\",\"rgb/1.5.png\"\n\"2.5\",\"rgb/2.5.png\"\n",
      "timestamp;filename\n1.5;rgb/1.5.png\n2.5;rgb/2.5.png\n",
      "1.5\trgb\\1.5.png\n2.5\trgb\\2.5.png\n",
      "index,file,time\n0,rgb/1.5.png,1.5\n1,rgb/2.5.png,2.5\n",
      "1.5,rgb/1.5.png,0.01,gain\n2.5,rgb/2.5.png,0.02,gain\n",
      "1.5 rgb/1.5.png 1.51 depth/1.5.png\n2.5 rgb/2.5.png 2.51 depth/2.5.png\n",
      "1.51 depth/1.5.png 1.5 rgb/1.5.png\n2.51 depth/2.5.png 2.5 rgb/2.5.png\n",
      "rgb/1.5.png 1.5\nrgb/2.5.png 2.5\n"};
  for (const std::string& text : timed) {
    WriteText("list.csv", text);
    const Seen seen = ReadAllOf(Path("list.csv"));
    EXPECT_THAT(seen.values, ElementsAre(10, 20)) << text;
    EXPECT_THAT(seen.times, ElementsAre(1.5, 2.5)) << text;
    EXPECT_THAT(seen.names, ElementsAre("1.5.png", "2.5.png")) << text;
  }
  EXPECT_THAT(RemarksOf("list.csv"), IsEmpty());
  WriteText("list.csv", timed[7]);
  EXPECT_THAT(RemarksOf("list.csv"), ElementsAre(HasSubstr("2 files in further columns")));
  WriteText("list.txt",
            "\xff\xfe"
            "a");
  EXPECT_THAT(ErrorOf("list.txt"), HasSubstr("UTF-16"));
  WriteText("list.txt", "1.5 depth/1.5.png\n2.5 depth/2.5.png\n");
  EXPECT_THAT(ErrorOf("list.txt"), HasSubstr("lists depth maps"));
}

TEST_F(FileListTest, NamesInListsHaveSpacesAndCommas) {
  for (const char* name : {"2024 trip/001.jpg", "named/a,1.jpg", "named/7 a;b,\"2\".jpg"}) {
    WritePicture(name, 10);
    WriteText("list.txt", std::string(name) + "\n");
    EXPECT_THAT(ReadAllOf(Path("list.txt")).times, ElementsAre(0.0)) << name;
    WriteText("list.txt", "0.25 " + std::string(name) + "\n");
    EXPECT_THAT(ReadAllOf(Path("list.txt")).times, ElementsAre(0.25)) << name;
    WriteText("list.txt", std::string(name) + ",0.25\n");
    EXPECT_THAT(ReadAllOf(Path("list.txt")).times, ElementsAre(0.25)) << name;
  }
}

// The names of pictures become names of masks, so none may lead out of a folder.
TEST_F(FileListTest, NamesOfPicturesAboveTheListAreRelativeToTheirOwnFolder) {
  WritePicture("images/1.png", 10);
  WritePicture("images/more/2.png", 20);
  fs::create_directories(Path("lists"));
  WriteText("lists/all.txt", "../images/1.png\n" + Path("images/more/2.png") + "\n");
  EXPECT_THAT(ReadAllOf(Path("lists/all.txt")).names, ElementsAre("1.png", "more/2.png"));
}

TEST_F(FileListTest, TimesInOtherUnitsAreRefusedByName) {
  for (const char* name : {"0.png", "1.png", "2.png"}) WritePicture(name, 10);
  const auto error = [&](double first, double step) {
    std::string text;
    for (int i = 0; i < 3; ++i) {
      text += std::to_string(static_cast<int64_t>(first + i * step)) + "," + std::to_string(i) +
              ".png\n";
    }
    WriteText("list.csv", text);
    return ErrorOf("list.csv");
  };
  EXPECT_THAT(error(1305031452791.0, 67.0), HasSubstr("they seem to be milliseconds"));
  EXPECT_THAT(error(1305031452791720.0, 66667.0), HasSubstr("they seem to be microseconds"));
  EXPECT_THAT(error(0.0, 66666667.0), HasSubstr("they seem to be nanoseconds"));
  EXPECT_THAT(error(1305031452.0, 5.0), "");
  WriteText("list.txt", "0.000000 0.png\n0.000000 1.png\n");
  EXPECT_THAT(ErrorOf("list.txt"), HasSubstr("line 2: the time 0 is equal to the one before it"));
}

}  // namespace
}  // namespace egosieve::vision
