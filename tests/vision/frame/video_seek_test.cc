// A frame is the same picture, at the same time, however it was reached, and a frame far ahead is
// reached from a key frame near it.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <tuple>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
}

#include "vision/frame/frame_source.h"
#include "vision/frame/quiet_libraries.h"

namespace {

std::atomic<int64_t> decoded_pictures = 0;

}  // namespace

// The program's own comes before FFmpeg's: OpenCV takes every decoded picture through it.
extern "C" int avcodec_receive_frame(AVCodecContext* context, AVFrame* frame) {
  static const auto receive =
      reinterpret_cast<decltype(&avcodec_receive_frame)>(dlsym(RTLD_NEXT, "avcodec_receive_frame"));
  const int code = receive(context, frame);
  if (code == 0) ++decoded_pictures;
  return code;
}

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 300;

// A textured picture that slides, so that frames refer to each other.
std::string WriteVideo(const std::string& name, const char* codec) {
  const std::string path = (fs::path(::testing::TempDir()) / name).string();
  cv::VideoWriter video(path, cv::CAP_FFMPEG,
                        cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]), 12.5,
                        cv::Size(64, 48));
  if (!video.isOpened()) return "";
  cv::Mat texture(48, 64 + kFrames, CV_8UC3);
  cv::theRNG().state = 3;
  cv::randu(texture, 0, 255);
  cv::GaussianBlur(texture, texture, cv::Size(), 1.5);
  for (int i = 0; i < kFrames; ++i) video << texture(cv::Rect(i, 0, 64, 48)).clone();
  return path;
}

// Those that cannot be decoded have an empty picture.
std::vector<Frame> ReadAll(const std::string& path) {
  const auto source = OpenFrameSource(path);
  std::vector<Frame> frames;
  while (source.ok()) {
    const absl::StatusOr<FrameRead> read = (*source)->Next();
    if (!read.ok() || std::holds_alternative<EndOfFrames>(*read)) break;
    const auto* frame = std::get_if<Frame>(&*read);
    frames.push_back(frame != nullptr ? *frame : Frame());
  }
  return frames;
}

void ExpectSameFrames(const std::string& path, const std::vector<int64_t>& indices) {
  const std::vector<Frame> frames = ReadAll(path);
  const auto count = static_cast<int64_t>(frames.size());
  ASSERT_GT(count, 200) << path;
  const auto source = OpenFrameSource(path);
  for (const int64_t at : indices) {
    ASSERT_TRUE((*source)->SeekTo(at).ok());
    for (int64_t i = at; i < std::min<int64_t>(at + 3, count); ++i) {
      const absl::StatusOr<FrameRead> read = (*source)->Next();
      ASSERT_TRUE(read.ok()) << path << " " << i << ": " << read.status();
      if (frames[i].image.empty()) {
        ASSERT_TRUE(std::holds_alternative<DamagedFrame>(*read)) << path << " " << i;
        EXPECT_EQ(std::get<DamagedFrame>(*read).index, i);
        continue;
      }
      ASSERT_TRUE(std::holds_alternative<Frame>(*read)) << path << " " << i;
      const Frame& frame = std::get<Frame>(*read);
      EXPECT_EQ(frame.index, i);
      EXPECT_EQ(frame.time_seconds, frames[i].time_seconds) << path << " " << i;
      EXPECT_EQ(cv::norm(frame.image, frames[i].image, cv::NORM_INF), 0.0) << path << " " << i;
    }
  }
  ASSERT_TRUE((*source)->SeekTo(count + 100).ok());
  const absl::StatusOr<FrameRead> end = (*source)->Next();
  ASSERT_TRUE(end.ok() && std::holds_alternative<EndOfFrames>(*end));
  EXPECT_EQ(std::get<EndOfFrames>(*end).frame_count, count);
}

TEST(VideoSeek, GivesTheFramesOfSequentialDecoding) {
  QuietLibraries();
  for (const auto& [name, codec] :
       {std::pair("key_frames.avi", "MJPG"), std::pair("groups.mp4", "mp4v"),
        std::pair("groups.mkv", "mp4v")}) {
    const std::string path = WriteVideo(name, codec);
    if (path.empty()) continue;
    ExpectSameFrames(path, {250, 100, 299, 0, 180, 143, 144, 145, 297});
  }
}

// Three videos of one folder.
std::string WriteChapters(const std::string& name, const char* codec, const char* extension) {
  const fs::path folder = fs::path(::testing::TempDir()) / name;
  fs::create_directories(folder);
  for (const char* chapter : {"1", "2", "3"}) {
    if (WriteVideo(name + "/" + chapter + extension, codec).empty()) return "";
  }
  return folder.string();
}

TEST(VideoSeek, GivesTheFramesOfChapters) {
  QuietLibraries();
  for (const auto& [name, codec, extension] :
       {std::tuple("key_frame_chapters", "MJPG", ".avi"), {"chapters", "mp4v", ".mp4"}}) {
    const std::string path = WriteChapters(name, codec, extension);
    ASSERT_NE(path, "") << name;
    ExpectSameFrames(path, {899, 250, 600, 598, 0, 299, 301, 750});
  }
}

// Overwrites the pictures with these indices in an AVI file of JPEGs: nothing of them is decoded. A
// picture's size, 32 bits with the least first, comes before it.
void DamagePictures(const std::string& path, const std::vector<int>& indices) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::vector<size_t> pictures;
  for (size_t at = 0; (at = bytes.find("\xff\xd8\xff", at)) != std::string::npos; ++at) {
    pictures.push_back(at);
  }
  ASSERT_EQ(pictures.size(), static_cast<size_t>(kFrames));
  for (const int index : indices) {
    uint32_t size = 0;
    std::memcpy(&size, &bytes[pictures[index] - sizeof(size)], sizeof(size));
    ASSERT_LT(pictures[index] + size, bytes.size());
    bytes.replace(pictures[index], size, std::string(size, 'x'));
  }
  file.seekp(0);
  file << bytes;
}

TEST(VideoSeek, KeepsTheIndicesBehindWhatCannotBeDecoded) {
  QuietLibraries();
  const std::string path = WriteVideo("damaged.avi", "MJPG");
  ASSERT_NE(path, "");
  const std::vector<Frame> whole = ReadAll(path);
  ASSERT_NO_FATAL_FAILURE(DamagePictures(path, {100, 210, 211}));
  const std::vector<Frame> frames = ReadAll(path);
  ASSERT_EQ(frames.size(), whole.size());
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_EQ(frames[i].image.empty(), i == 100 || i == 210 || i == 211) << i;
    if (frames[i].image.empty()) continue;
    EXPECT_EQ(cv::norm(frames[i].image, whole[i].image, cv::NORM_INF), 0.0) << i;
    EXPECT_EQ(frames[i].time_seconds, whole[i].time_seconds) << i;
  }
  ExpectSameFrames(path, {250, 100, 99, 209, 210, 211, 212, 299, 0, 101});
}

// The last ones are no damaged frames, for a video that is cut short ends there, too.
TEST(VideoSeek, FindsTheSameEnd) {
  QuietLibraries();
  const std::string path = WriteVideo("end.avi", "MJPG");
  ASSERT_NE(path, "");
  ASSERT_NO_FATAL_FAILURE(DamagePictures(path, {298, 299}));
  ASSERT_EQ(ReadAll(path).size(), 298u);
  ExpectSameFrames(path, {296, 150});
}

// Pictures that are decoded so that frame `index` is delivered by a source that has delivered none.
int64_t PicturesDecodedFor(const std::string& path, int64_t index) {
  const auto source = OpenFrameSource(path);
  if (!source.ok() || !(*source)->SeekTo(index).ok()) return -1;
  decoded_pictures = 0;
  const absl::StatusOr<FrameRead> read = (*source)->Next();
  if (!read.ok() || !std::holds_alternative<Frame>(*read)) return -1;
  return decoded_pictures;
}

// OpenCV goes back 16 frames from the one that it is asked for, which is 2 before a key frame, and
// then to the key frame before that.
TEST(VideoSeek, DecodesFromAKeyFrameNearby) {
  QuietLibraries();
  constexpr int64_t kBack = 18;
  constexpr int64_t kGroup = 12;  // OpenCV's writer: frames from one key frame to the next
  for (const auto& [name, codec, interval] :
       {std::tuple("near.avi", "MJPG", int64_t{1}), std::tuple("near.mp4", "mp4v", kGroup),
        std::tuple("near.mkv", "mp4v", kGroup)}) {
    const std::string path = WriteVideo(name, codec);
    ASSERT_NE(path, "") << name;
    EXPECT_GE(PicturesDecodedFor(path, 60), 60) << "the pictures are not counted";
    for (const int64_t index : {100, 143, 144, 200, 250, 298}) {
      const int64_t decoded = PicturesDecodedFor(path, index);
      EXPECT_GE(decoded, 1) << path << " " << index;
      EXPECT_LE(decoded, 2 * interval + kBack) << path << " " << index;
    }
  }
}

TEST(VideoSeek, DecodesTheEndsOfChaptersBefore) {
  QuietLibraries();
  constexpr int64_t kBack = 18;
  constexpr int64_t kOpening = 1;  // each video shows that it has pictures
  for (const auto& [name, codec, extension, interval] :
       {std::tuple("key_frame_ends", "MJPG", ".avi", int64_t{1}),
        {"ends", "mp4v", ".mp4", int64_t{12}}}) {
    const std::string path = WriteChapters(name, codec, extension);
    ASSERT_NE(path, "") << name;
    for (const int64_t index : {500, 898}) {
      const int64_t videos = index / kFrames + 1;
      const int64_t decoded = PicturesDecodedFor(path, index);
      EXPECT_GE(decoded, videos) << path << " " << index;
      EXPECT_LE(decoded, videos * (2 * interval + kBack + kOpening)) << path << " " << index;
    }
  }
}

// H.264 with frames that refer to later ones.
TEST(VideoSeek, OfRealVideos) {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA is not set";
  for (const char* name : {"/highway/solidWhiteRight.mp4", "/highway/dashcam_reflections.mp4"}) {
    if (!fs::exists(std::string(data) + name)) GTEST_SKIP() << "there is no " << data << name;
    ExpectSameFrames(std::string(data) + name, {200, 90, 217, 130});
  }
}

}  // namespace
}  // namespace egosieve::vision
