// Videos whose containers, names and pictures are not as their headers or their first picture say.
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <variant>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/testing/status.h"
#include "tests/vision/frame/input_test.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class VideoForms : public InputTest {
 protected:
  std::string Bytes(const std::string& name) const {
    std::ifstream file(Path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void Write(const std::string& name, const std::string& bytes) const {
    std::ofstream(Path(name), std::ios::binary) << bytes;
  }
  // The warning at the end of an input of which `values` are read.
  std::string EndOf(const std::string& name, const std::vector<int>& values) const {
    const auto source = OpenFrameSource(Path(name));
    EXPECT_TRUE(source.ok()) << source.status();
    if (!source.ok()) return "";
    EXPECT_EQ(ReadAll(**source).values, values);
    return std::get<EndOfFrames>(*(*source)->Next()).warning;
  }
};

// A stream of JPEGs, some of them grey and some of another size.
TEST_F(VideoForms, EachPictureHasItsOwnSizeAndFormat) {
  const cv::Vec3b colours[] = {{200, 60, 20}, {90, 90, 90}, {60, 40, 220}, {120, 120, 120}};
  const cv::Size sizes[] = {{64, 48}, {64, 48}, {32, 48}, {64, 48}};
  std::string stream;
  for (int i = 0; i < 4; ++i) {
    const bool is_grey = i % 2 == 1;
    const cv::Mat picture = is_grey ? cv::Mat(cv::Mat1b(sizes[i], colours[i][0]))
                                    : cv::Mat(cv::Mat3b(sizes[i], colours[i]));
    std::vector<uchar> jpeg;
    ASSERT_TRUE(cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, 95}));
    stream.append(jpeg.begin(), jpeg.end());
  }
  Write("camera.mjpeg", stream);
  const auto source = Value(OpenFrameSource(Path("camera.mjpeg")));
  double last = -1.0;
  for (int i = 0; i < 4; ++i) {
    const auto read = source->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read)) << i;
    const Frame& frame = std::get<Frame>(*read);
    EXPECT_EQ(frame.image.size(), sizes[i]) << i;
    EXPECT_GT(frame.time_seconds, last);
    last = frame.time_seconds;
    // Rounding to limited range and back, and JPEG's own: a few grey levels.
    const cv::Mat3b image = frame.image;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(image(20, 15)[c], colours[i][c], 6) << i << ", " << c;
  }
  EXPECT_TRUE(std::holds_alternative<EndOfFrames>(*source->Next()));
}

TEST_F(VideoForms, NamesMayHaveColons) {
  WriteVideo("plain.avi", 0, 5, 10);
  for (const char* name : {"2024-05-01_12:30:00.avi", "rtsp:1.avi", "per%03d.avi"}) {
    fs::copy_file(Path("plain.avi"), Path(name));
    EXPECT_THAT(EndOf(name, {0, 10, 20, 30, 40}), IsEmpty()) << name;
  }
}

TEST_F(VideoForms, WhatFollowsAWholeFileDoesNotCutItShort) {
  for (const char* name : {"a.avi", "a.mp4", "a.mkv"}) {
    WriteVideo(name, 0, 5, 10);
    const std::string whole = Bytes(name);
    Write(name, whole + std::string(3000, '\0'));
    EXPECT_THAT(EndOf(name, {0, 10, 20, 30, 40}), IsEmpty()) << name;
  }
}

TEST_F(VideoForms, WhatEndsWithinAPartIsCutShort) {
  WriteVideo("a.avi", 0, 24, 10);
  const std::string whole = Bytes("a.avi");
  Write("a.avi", whole.substr(0, whole.size() * 4 / 5));
  const auto source = Value(OpenFrameSource(Path("a.avi")));
  const Seen seen = ReadAll(*source);
  EXPECT_GT(seen.values.size(), 2u);
  EXPECT_LT(seen.values.size(), 24u);
  EXPECT_THAT(std::get<EndOfFrames>(*source->Next()).warning, HasSubstr("a.avi: cut short"));
}

TEST_F(VideoForms, ARecordingThatWasNeverClosedIsTold) {
  WriteVideo("a.mp4", 0, 8, 10);
  const std::string whole = Bytes("a.mp4");
  const size_t table = whole.find("moov");
  ASSERT_NE(table, std::string::npos);
  Write("a.mp4", whole.substr(0, table - 4));
  EXPECT_THAT(ErrorOf("a.mp4"), AllOf(HasSubstr("a.mp4: cut short"), HasSubstr("never closed")));
}

TEST_F(VideoForms, ADamagedChapterCostsItselfAlone) {
  WriteVideo("card/1.avi", 0, 3, 10);
  WriteVideo("card/3.avi", 3, 3, 10);
  Write("card/2.avi", Bytes("card/1.avi").substr(0, 100));
  EXPECT_THAT(EndOf("card", {0, 10, 20, 30, 40, 50}),
              AllOf(HasSubstr("card/2.avi"), HasSubstr("left out")));
  fs::remove(Path("card/1.avi"));
  fs::remove(Path("card/3.avi"));
  EXPECT_THAT(ErrorOf("card"), HasSubstr("card/2.avi"));
}

}  // namespace
}  // namespace egosieve::vision
