#include "vision/frame/frame_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "tests/vision/frame/folder_test.h"
#include "vision/frame/pixel_limit.h"
#include "vision/frame/stepped_frames.h"
#include "vision/frame/written_video.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class FrameSourceTest : public FolderTest {
 protected:
  void WriteImage(const std::string& name, const cv::Mat& image) const {
    ASSERT_TRUE(cv::imwrite(Path(name), image));
  }

  void WriteText(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name), std::ios::binary) << text;
  }

  // A video whose frame k is noise around 10 k + 20 grey.
  void WriteVideo(const std::string& name, int count) const {
    cv::VideoWriter writer(Path(name), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                           8.0, cv::Size(64, 48));
    ASSERT_TRUE(writer.isOpened());
    for (int k = 0; k < count; ++k) {
      cv::Mat image(48, 64, CV_8UC3);
      cv::theRNG().state = 7;
      cv::randu(image, 10 * k, 10 * k + 40);
      writer.write(image);
    }
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

TEST(NaturalLess, ComparesRunsOfDigitsAsNumbers) {
  EXPECT_TRUE(NaturalLess("f9.png", "f10.png"));
  EXPECT_FALSE(NaturalLess("f10.png", "f9.png"));
  EXPECT_TRUE(NaturalLess("f009.png", "f10.png"));
  EXPECT_TRUE(NaturalLess("a2b1", "a2b3"));
  EXPECT_TRUE(NaturalLess("a", "a1"));
  EXPECT_FALSE(NaturalLess("x", "x"));
  // Beyond the range of any integer type.
  EXPECT_TRUE(NaturalLess("1" + std::string(40, '0'), "2" + std::string(40, '0')));
}

TEST(NaturalLess, IsAStrictWeakOrdering) {
  const std::vector<std::string> names = {"",    "1",  "01",  "001", "1a", "01b", "a",     "a0",
                                          "a00", "a1", "a01", "b",   "10", "9",   "a9b10", "a9b9"};
  for (const auto& a : names) {
    EXPECT_FALSE(NaturalLess(a, a));
    for (const auto& b : names) {
      if (a != b) {
        EXPECT_NE(NaturalLess(a, b), NaturalLess(b, a)) << a << " " << b;
      }
      for (const auto& c : names) {
        if (NaturalLess(a, b) && NaturalLess(b, c)) {
          EXPECT_TRUE(NaturalLess(a, c)) << a << b << c;
        }
      }
    }
  }
}

TEST_F(FrameSourceTest, FolderInNaturalOrderWithTimesAndEnd) {
  for (const int k : {10, 9, 1})
    WriteImage(std::to_string(k) + ".png", Solid(CV_8UC3, cv::Scalar::all(k)));
  WriteText("notes.txt", "not a picture");
  WriteImage(".hidden.png", Solid(CV_8UC3, cv::Scalar::all(99)));
  FrameSourceOptions options;
  options.nominal_rate_hz = 4.0;
  auto source = OpenFrameSource(folder_.string(), options);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->expected_frame_count(), 3);
  for (int index = 0; index < 3; ++index) {
    const auto read = (*source)->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
    const Frame& frame = std::get<Frame>(*read);
    EXPECT_EQ(frame.index, index);
    EXPECT_DOUBLE_EQ(frame.time_seconds, index / 4.0);
    EXPECT_EQ(frame.image.at<cv::Vec3b>(2, 2)[1], (std::vector<int>{1, 9, 10}[index]));
  }
  for (int again = 0; again < 2; ++again) {
    const auto end = (*source)->Next();
    ASSERT_TRUE(end.ok() && std::holds_alternative<EndOfFrames>(*end));
    EXPECT_EQ(std::get<EndOfFrames>(*end).frame_count, 3);
  }
}

TEST_F(FrameSourceTest, EveryPixelFormatBecomesEightBitBgr) {
  WriteImage("0.png", Solid(CV_8UC1, cv::Scalar(7)));
  WriteImage("1.png", Solid(CV_16UC1, cv::Scalar(257 * 200)));
  WriteImage("2.png", Solid(CV_16UC3, cv::Scalar(257 * 1, 257 * 2, 257 * 3)));
  WriteImage("3.png", Solid(CV_8UC4, cv::Scalar(1, 2, 3, 0)));
  WriteImage("4.png", Solid(CV_16UC4, cv::Scalar(257, 514, 771, 65535)));
  auto source = OpenFrameSource(Path("*.png"));
  ASSERT_TRUE(source.ok()) << source.status();
  const cv::Vec3b expected[] = {{7, 7, 7}, {200, 200, 200}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}};
  for (int index = 0; index < 5; ++index) {
    const auto read = (*source)->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read)) << index;
    const Frame& frame = std::get<Frame>(*read);
    ASSERT_EQ(frame.image.type(), CV_8UC3) << index;
    EXPECT_EQ(frame.image.at<cv::Vec3b>(3, 3), expected[index]) << index;
    EXPECT_EQ(frame.is_grey, index < 2) << index;
  }
}

TEST_F(FrameSourceTest, ImagesOfDifferentSizesAreDelivered) {
  WriteImage("a.png", cv::Mat(6, 8, CV_8UC3, cv::Scalar::all(1)));
  WriteImage("b.png", cv::Mat(12, 5, CV_8UC3, cv::Scalar::all(1)));
  auto source = OpenFrameSource(folder_.string());
  ASSERT_TRUE(source.ok());
  EXPECT_EQ(std::get<Frame>(*(*source)->Next()).image.size(), cv::Size(8, 6));
  EXPECT_EQ(std::get<Frame>(*(*source)->Next()).image.size(), cv::Size(5, 12));
}

TEST_F(FrameSourceTest, DamagedPicturesAreReportedAndSkipped) {
  cv::Mat noise(64, 64, CV_8UC3);
  cv::theRNG().state = 1;
  cv::randu(noise, 0, 255);
  for (const char* name : {"0.png", "1.png", "2.jpg", "4.png"}) WriteImage(name, noise);
  fs::resize_file(Path("1.png"), fs::file_size(Path("1.png")) / 2);
  fs::resize_file(Path("2.jpg"), fs::file_size(Path("2.jpg")) / 2);
  WriteText("3.png", "");
  auto source = OpenFrameSource(folder_.string());
  ASSERT_TRUE(source.ok());
  for (int index = 0; index < 5; ++index) {
    const auto read = (*source)->Next();
    ASSERT_TRUE(read.ok());
    if (index == 0 || index == 4) {
      ASSERT_TRUE(std::holds_alternative<Frame>(*read)) << index;
      EXPECT_EQ(std::get<Frame>(*read).index, index);
    } else {
      ASSERT_TRUE(std::holds_alternative<DamagedFrame>(*read)) << index;
      EXPECT_EQ(std::get<DamagedFrame>(*read).index, index);
      EXPECT_THAT(std::get<DamagedFrame>(*read).reason, HasSubstr(std::to_string(index) + "."));
    }
  }
}

// The decoder tells whether a JPEG is whole, not a marker somewhere in the file.
TEST_F(FrameSourceTest, WholeJpegsAreReadWhateverLiesBehindThem) {
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
    const auto source = OpenFrameSource(Path("a.jpg"));
    ASSERT_TRUE(source.ok()) << source.status();
    const auto frame = (*source)->Next();
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

TEST_F(FrameSourceTest, WholePngsAreReadWhateverLiesBehindThem) {
  std::vector<uint8_t> encoded;
  cv::imencode(".png", Solid(CV_8UC3, cv::Scalar(1, 2, 3)), encoded);
  const std::string whole(encoded.begin(), encoded.end());
  WriteText("a.png", whole + std::string(9000, 'x'));
  EXPECT_TRUE(OpenFrameSource(Path("a.png")).ok());
  WriteText("a.png", whole.substr(0, whole.size() - 20) + "IEND");
  EXPECT_THAT(MessageOf(OpenFrameSource(Path("a.png")).status()), HasSubstr("cut short"));
}

// Counts of a thermal camera, 12 bits of a machine camera, and floats in other units.
TEST_F(FrameSourceTest, ValuesOfAPartOfTheirRangeAreStretchedAlikeInAllFrames) {
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
    const auto source = OpenFrameSource(Path(kind.name));
    ASSERT_TRUE(source.ok()) << source.status();
    const bool is_full = kind.step == 257;
    EXPECT_EQ((*source)->remarks().size(), is_full ? 0u : 1u) << kind.name;
    for (const int most : {255, 127}) {  // "127.tiff" is the first
      ASSERT_TRUE((*source)->SeekTo(most == 127 ? 0 : 1).ok());
      const auto read = (*source)->Next();
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

TEST_F(FrameSourceTest, ErrorsNameTheInputAndWhatToDo) {
  WriteText("fake.mp4", "this is no video\n");
  fs::create_directories(Path("empty"));
  WriteText("broken.png", "no picture");
  const auto missing = OpenFrameSource(Path("nowhere.mp4"));
  EXPECT_EQ(missing.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(MessageOf(missing.status()), HasSubstr("nowhere.mp4: no such file"));
  const auto fake = OpenFrameSource(Path("fake.mp4"));
  EXPECT_EQ(fake.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(MessageOf(fake.status()), HasSubstr("fake.mp4: not a video"));
  const auto empty = OpenFrameSource(Path("empty"));
  EXPECT_EQ(empty.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(MessageOf(empty.status()), HasSubstr("no pictures in this folder"));
  const auto broken = OpenFrameSource(Path("broken.png"));
  EXPECT_EQ(broken.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(OpenFrameSource(Path("*.tiff")).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(OpenFrameSource(Path("*.mp4")).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(OpenFrameSource("").ok());
  FrameSourceOptions options;
  options.nominal_rate_hz = std::nan("");
  EXPECT_FALSE(OpenFrameSource(Path("broken.png"), options).ok());
  for (const auto& status : {missing.status(), fake.status(), empty.status(), broken.status()}) {
    EXPECT_EQ(MessageOf(status).find('\n'), std::string::npos) << "one line";
  }
}

TEST_F(FrameSourceTest, VideoHasTimesFromItsStreamAndSeeksToTheSamePictures) {
  WriteVideo("v.avi", 12);
  auto source = OpenFrameSource(Path("v.avi"));
  ASSERT_TRUE(source.ok()) << source.status();
  std::vector<cv::Mat> images;
  while (true) {
    const auto read = (*source)->Next();
    ASSERT_TRUE(read.ok());
    if (std::holds_alternative<EndOfFrames>(*read)) break;
    const Frame& frame = std::get<Frame>(*read);
    EXPECT_EQ(frame.index, static_cast<int64_t>(images.size()));
    EXPECT_NEAR(frame.time_seconds, frame.index / 8.0, 1e-3);
    // Later frames do not overwrite earlier ones.
    images.push_back(frame.image);
  }
  ASSERT_EQ(images.size(), 12u);
  EXPECT_NE(images[0].at<cv::Vec3b>(9, 9), images[1].at<cv::Vec3b>(9, 9));
  for (const int64_t index : {7, 3, 0, 11, 4}) {
    ASSERT_TRUE((*source)->SeekTo(index).ok());
    EXPECT_EQ((*source)->next_index(), index);
    const auto read = (*source)->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
    EXPECT_EQ(std::get<Frame>(*read).index, index);
    EXPECT_EQ(cv::norm(std::get<Frame>(*read).image, images[index], cv::NORM_INF), 0.0);
  }
  ASSERT_TRUE((*source)->SeekTo(50).ok());
  const auto end = (*source)->Next();
  ASSERT_TRUE(end.ok() && std::holds_alternative<EndOfFrames>(*end));
  EXPECT_EQ(std::get<EndOfFrames>(*end).frame_count, 12);
  EXPECT_FALSE((*source)->SeekTo(-1).ok());
}

TEST_F(FrameSourceTest, TruncatedVideoDeliversWhatIsThereAndSaysSo) {
  WriteVideo("v.avi", 12);
  fs::resize_file(Path("v.avi"), fs::file_size(Path("v.avi")) * 6 / 10);
  auto source = OpenFrameSource(Path("v.avi"));
  ASSERT_TRUE(source.ok()) << source.status();
  int64_t count = 0;
  while (true) {
    const auto read = (*source)->Next();
    ASSERT_TRUE(read.ok());
    if (std::holds_alternative<EndOfFrames>(*read)) {
      EXPECT_EQ(std::get<EndOfFrames>(*read).frame_count, count);
      EXPECT_THAT(std::get<EndOfFrames>(*read).warning, HasSubstr("ended after"));
      break;
    }
    ++count;
  }
  EXPECT_GT(count, 0);
  EXPECT_LT(count, 12);
}

// As one that a camera still writes: what was found out before may not hold for the rest.
TEST_F(FrameSourceTest, AVideoThatGrowsWhileItIsReadIsTold) {
  WriteVideo("v.avi", 12);
  for (const bool grows : {false, true}) {
    const auto source = OpenFrameSource(Path("v.avi"));
    ASSERT_TRUE(source.ok()) << source.status();
    ASSERT_TRUE((*source)->SeekTo(5).ok());
    ASSERT_TRUE((*source)->Next().ok());
    if (grows) std::ofstream(Path("v.avi"), std::ios::app) << "more";
    ASSERT_TRUE((*source)->SeekTo(12).ok());
    const auto read = (*source)->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<EndOfFrames>(*read));
    EXPECT_EQ(std::get<EndOfFrames>(*read).frame_count, 12);
    EXPECT_EQ(
        std::get<EndOfFrames>(*read).warning.find("changed while it was read") != std::string::npos,
        grows);
  }
}

TEST_F(FrameSourceTest, VideoWithoutFramesIsAnError) {
  WriteVideo("v.avi", 12);
  // The headers of the container are there, the first picture is not.
  std::ifstream file(Path("v.avi"), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const size_t pictures = bytes.find("movi");
  ASSERT_NE(pictures, std::string::npos);
  fs::resize_file(Path("v.avi"), pictures + 4);
  const auto source = OpenFrameSource(Path("v.avi"));
  ASSERT_FALSE(source.ok());
  EXPECT_EQ(source.status().code(), absl::StatusCode::kInvalidArgument);
}

// GDCM, a decoder behind OpenCV, ends the process on these bytes.
TEST_F(FrameSourceTest, WhatIsNoPictureReachesNoOtherDecoder) {
  const std::string dicom =
      std::string(128, '\0') + "DICM" + std::string("\0\0\xff\xd8SVD\xae\x42\x60\x82", 11);
  std::ofstream(Path("dicom.png"), std::ios::binary) << dicom;
  EXPECT_THAT(std::string(OpenFrameSource(Path("dicom.png")).status().message()),
              HasSubstr("cannot be decoded as a picture"));
}

TEST_F(FrameSourceTest, NothingIsPrinted) {
  WriteText("fake.mp4", std::string(5000, 'x'));
  WriteVideo("v.avi", 6);
  fs::resize_file(Path("v.avi"), fs::file_size(Path("v.avi")) * 7 / 10);
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  (void)OpenFrameSource(Path("fake.mp4"));
  (void)OpenFrameSource(Path("nowhere.png"));
  auto source = OpenFrameSource(Path("v.avi"));
  while (source.ok()) {
    const auto read = (*source)->Next();
    if (!read.ok() || std::holds_alternative<EndOfFrames>(*read)) break;
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

TEST(PixelLimit, TakesWhatCamerasGive) {
  EXPECT_TRUE(CheckPixels(7680, 4320).ok());
  EXPECT_TRUE(CheckPixels(15360, 8640).ok());
  EXPECT_FALSE(CheckPixels(30000, 30000).ok());
  EXPECT_FALSE(CheckPixels(int64_t{1} << 32, int64_t{1} << 32).ok());
}

// A few bytes may say that gigabytes follow: refused before anything is decoded.
TEST_F(FrameSourceTest, PicturesOfTooManyPixelsAreRefusedByTheirHeader) {
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

TEST_F(FrameSourceTest, AVideoThatIsNotAllThereIsFoundOut) {
  WriteVideo("whole.avi", 6);
  EXPECT_TRUE(CheckWrittenVideo(Path("whole.avi"), 6).ok());
  EXPECT_FALSE(CheckWrittenVideo(Path("whole.avi"), 7).ok());
  fs::resize_file(Path("whole.avi"), 100);
  EXPECT_FALSE(CheckWrittenVideo(Path("whole.avi"), 6).ok());
  EXPECT_FALSE(CheckWrittenVideo(Path("none.avi"), 6).ok());
}

TEST_F(FrameSourceTest, SteppedFramesKeepTheirIndexTimeAndName) {
  for (int k = 0; k < 9; ++k) {
    WriteImage(std::to_string(k) + ".png", Solid(CV_8UC3, cv::Scalar::all(10 * k)));
  }
  SteppedFrames frames(*OpenFrameSource(folder_.string(), {}), 1, 3);
  const auto expect_next = [&](int64_t index) {
    const auto read = frames.Next();
    ASSERT_TRUE(read.ok()) << read.status();
    const auto* frame = std::get_if<Frame>(&*read);
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->index, index);
    EXPECT_DOUBLE_EQ(frame->time_seconds, 0.1 * static_cast<double>(index));
    EXPECT_EQ(frame->image.at<cv::Vec3b>(0, 0)[0], 10 * index);
    EXPECT_EQ(frames.image_name(frame->index), std::to_string(index) + ".png");
  };
  for (const int64_t index : {1, 4, 7}) expect_next(index);
  EXPECT_EQ(frames.next_index(), 10);
  EXPECT_TRUE(std::holds_alternative<EndOfFrames>(*frames.Next()));
  // To the first that is delivered from there on.
  for (const auto& [asked, given] : {std::pair(0, 1), {4, 4}, {5, 7}}) {
    ASSERT_TRUE(frames.SeekTo(asked).ok());
    EXPECT_EQ(frames.next_index(), given);
    expect_next(given);
  }
  EXPECT_FALSE(frames.SeekTo(-1).ok());
}

}  // namespace
}  // namespace egosieve::vision
