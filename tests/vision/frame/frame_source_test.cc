#include "vision/frame/frame_source.h"

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "tests/testing/status.h"
#include "tests/vision/frame/input_test.h"
#include "vision/frame/stepped_frames.h"
#include "vision/frame/video_file.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class FrameSourceTest : public FolderTest {
 protected:
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
  auto source = Value(OpenFrameSource(folder_.string(), {.nominal_rate_hz = 4.0}));
  EXPECT_EQ(source->expected_frame_count(), 3);
  for (int index = 0; index < 3; ++index) {
    const auto read = source->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
    const Frame& frame = std::get<Frame>(*read);
    EXPECT_EQ(frame.index, index);
    EXPECT_DOUBLE_EQ(frame.time_seconds, index / 4.0);
    EXPECT_EQ(frame.image.at<cv::Vec3b>(2, 2)[1], (std::vector<int>{1, 9, 10}[index]));
  }
  for (int again = 0; again < 2; ++again) {
    const auto end = source->Next();
    ASSERT_TRUE(end.ok() && std::holds_alternative<EndOfFrames>(*end));
    EXPECT_EQ(std::get<EndOfFrames>(*end).frame_count, 3);
  }
}

TEST_F(FrameSourceTest, ImagesOfDifferentSizesAreDelivered) {
  WriteImage("a.png", cv::Mat(6, 8, CV_8UC3, cv::Scalar::all(1)));
  WriteImage("b.png", cv::Mat(12, 5, CV_8UC3, cv::Scalar::all(1)));
  auto source = Value(OpenFrameSource(folder_.string()));
  EXPECT_EQ(std::get<Frame>(*source->Next()).image.size(), cv::Size(8, 6));
  EXPECT_EQ(std::get<Frame>(*source->Next()).image.size(), cv::Size(5, 12));
}

TEST_F(FrameSourceTest, ErrorsNameTheInputAndWhatToDo) {
  WriteText("fake.mp4", "this is no video\n");
  fs::create_directories(Path("empty"));
  WriteText("broken.png", "no picture");
  const auto missing = OpenFrameSource(Path("nowhere.mp4"));
  EXPECT_EQ(missing.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(MessageOf(missing.status()), HasSubstr("nowhere.mp4: no such file"));
  const auto fake = OpenFrameSource(Path("fake.mp4"));
  EXPECT_THAT(fake, IsInvalid("fake.mp4: not a video"));
  const auto empty = OpenFrameSource(Path("empty"));
  EXPECT_THAT(empty, IsInvalid("no pictures in this folder"));
  const auto broken = OpenFrameSource(Path("broken.png"));
  EXPECT_THAT(broken, IsInvalid());
  EXPECT_EQ(OpenFrameSource(Path("*.tiff")).status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(OpenFrameSource(Path("*.mp4")), IsInvalid());
  EXPECT_FALSE(OpenFrameSource("").ok());
  EXPECT_FALSE(OpenFrameSource(Path("broken.png"), {.nominal_rate_hz = std::nan("")}).ok());
  for (const auto& status : {missing.status(), fake.status(), empty.status(), broken.status()}) {
    EXPECT_EQ(MessageOf(status).find('\n'), std::string::npos) << "one line";
  }
}

TEST_F(FrameSourceTest, VideoHasTimesFromItsStreamAndSeeksToTheSamePictures) {
  WriteVideo("v.avi", 12);
  auto source = Value(OpenFrameSource(Path("v.avi")));
  std::vector<cv::Mat> images;
  while (true) {
    const auto read = Value(source->Next());
    if (std::holds_alternative<EndOfFrames>(read)) break;
    const Frame& frame = std::get<Frame>(read);
    EXPECT_EQ(frame.index, static_cast<int64_t>(images.size()));
    EXPECT_NEAR(frame.time_seconds, frame.index / 8.0, 1e-3);
    // Later frames do not overwrite earlier ones.
    images.push_back(frame.image);
  }
  ASSERT_EQ(images.size(), 12u);
  EXPECT_NE(images[0].at<cv::Vec3b>(9, 9), images[1].at<cv::Vec3b>(9, 9));
  for (const int64_t index : {7, 3, 0, 11, 4}) {
    ASSERT_TRUE(source->SeekTo(index).ok());
    EXPECT_EQ(source->next_index(), index);
    const auto read = source->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
    EXPECT_EQ(std::get<Frame>(*read).index, index);
    EXPECT_EQ(cv::norm(std::get<Frame>(*read).image, images[index], cv::NORM_INF), 0.0);
  }
  ASSERT_TRUE(source->SeekTo(50).ok());
  const auto end = source->Next();
  ASSERT_TRUE(end.ok() && std::holds_alternative<EndOfFrames>(*end));
  EXPECT_EQ(std::get<EndOfFrames>(*end).frame_count, 12);
  EXPECT_FALSE(source->SeekTo(-1).ok());
}

TEST_F(FrameSourceTest, TruncatedVideoDeliversWhatIsThereAndSaysSo) {
  WriteVideo("v.avi", 12);
  fs::resize_file(Path("v.avi"), fs::file_size(Path("v.avi")) * 6 / 10);
  auto source = Value(OpenFrameSource(Path("v.avi")));
  int64_t count = 0;
  while (true) {
    const auto read = Value(source->Next());
    if (std::holds_alternative<EndOfFrames>(read)) {
      EXPECT_EQ(std::get<EndOfFrames>(read).frame_count, count);
      EXPECT_THAT(std::get<EndOfFrames>(read).warning, HasSubstr("ended after"));
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
    const auto source = Value(OpenFrameSource(Path("v.avi")));
    ASSERT_TRUE(source->SeekTo(5).ok());
    ASSERT_TRUE(source->Next().ok());
    if (grows) std::ofstream(Path("v.avi"), std::ios::app) << "more";
    ASSERT_TRUE(source->SeekTo(12).ok());
    const auto read = source->Next();
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
  EXPECT_THAT(source, IsInvalid());
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
    const auto read = Value(frames.Next());
    const auto* frame = std::get_if<Frame>(&read);
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
