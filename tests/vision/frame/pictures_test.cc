#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <variant>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/testing/status.h"
#include "tests/vision/frame/folder_test.h"
#include "vision/frame/equalization.h"
#include "vision/frame/frame_source.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/pixel_limit.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class ImageDecodingTest : public FolderTest {
 protected:
  void WriteImage(const std::string& name, const cv::Mat& image) const {
    ASSERT_TRUE(cv::imwrite(Path(name), image));
  }
};

cv::Mat Solid(int type, const cv::Scalar& value) { return cv::Mat(6, 8, type, value); }

// A number of `size` bytes, the highest first.
std::string BigEndian(int64_t value, int size) {
  std::string bytes;
  for (int i = size - 1; i >= 0; --i) bytes.push_back(static_cast<char>(value >> (8 * i)));
  return bytes;
}

std::string MessageOf(const absl::Status& status) { return std::string(status.message()); }

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
    EqualizationOptions options;
    options.method = method;
    const cv::Mat result = EqualizeLuminance(image, options);
    ASSERT_EQ(result.type(), CV_8UC3);
    EXPECT_GT(LuminanceRange(result), 1.5 * LuminanceRange(image));
    EXPECT_EQ(cv::norm(image, before, cv::NORM_INF), 0.0);
  }
}

// Adding a constant shifts the histogram and leaves its shape: equalisation must undo it.
TEST(EqualizeLuminance, GlobalTakesOutAChangeOfLight) {
  EqualizationOptions options;
  options.method = Equalization::kGlobal;
  cv::Mat grey;
  cv::cvtColor(DarkPicture(), grey, cv::COLOR_BGR2GRAY);
  const cv::Mat brighter = grey + 50;
  EXPECT_EQ(cv::norm(EqualizeLuminance(grey, options), EqualizeLuminance(brighter, options),
                     cv::NORM_INF),
            0.0);
}

TEST(EqualizationOptions, NonsenseIsRefused) {
  EqualizationOptions options;
  options.clahe_clip_limit = std::nan("");
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.clahe_tiles = 0;
  EXPECT_FALSE(options.Validate().ok());
}

}  // namespace
}  // namespace egosieve::vision
