// Videos whose containers, names and pictures are not as their headers or their first picture say.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <variant>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "tests/testing/status.h"
#include "tests/vision/frame/input_test.h"
#include "vision/frame/av_input.h"
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

// Videos as phones and old cameras make them, written by FFmpeg's own encoder: what is read of
// them, and what is said of them.

constexpr int kWidth = 64, kHeight = 48;

struct Kind {
  AVPixelFormat format = AV_PIX_FMT_YUV420P;
  AVColorTransferCharacteristic transfer = AVCOL_TRC_BT709;
  AVFieldOrder fields = AV_FIELD_PROGRESSIVE;
  const char* created = nullptr;
  int frames = 3;  // ten a second
};

// Brightness that grows from column to column through all of "limited range": 16 to 235 of 8 bits.
double Brightness(int column) { return 16.0 + 219.0 * column / (kWidth - 1); }

void Fill(const Kind& kind, AVFrame* frame) {
  const bool is_deep = kind.format == AV_PIX_FMT_YUV420P10;
  for (int plane = 0; plane < 3; ++plane) {
    const int step = plane == 0 ? 1 : 2;
    for (int y = 0; y < kHeight / step; ++y) {
      uint8_t* row = frame->data[plane] + y * frame->linesize[plane];
      for (int x = 0; x < kWidth / step; ++x) {
        const double value = plane == 0 ? Brightness(x) : 128.0;
        if (is_deep) {
          reinterpret_cast<uint16_t*>(row)[x] = static_cast<uint16_t>(std::lround(4.0 * value));
        } else {
          row[x] = static_cast<uint8_t>(std::lround(value));
        }
      }
    }
  }
}

std::string WriteVideo(const std::string& name, const Kind& kind) {
  const std::string path = ::testing::TempDir() + "/" + name + ".mkv";
  AVFormatContext* file = nullptr;
  EXPECT_GE(avformat_alloc_output_context2(&file, nullptr, nullptr, path.c_str()), 0);
  AVCodecContext* codec = avcodec_alloc_context3(avcodec_find_encoder(AV_CODEC_ID_FFV1));
  codec->width = kWidth;
  codec->height = kHeight;
  codec->pix_fmt = kind.format;
  codec->time_base = {1, 10};
  codec->color_trc = kind.transfer;
  codec->field_order = kind.fields;
  if (kind.fields != AV_FIELD_PROGRESSIVE) codec->flags |= AV_CODEC_FLAG_INTERLACED_DCT;
  EXPECT_GE(avcodec_open2(codec, nullptr, nullptr), 0);
  AVStream* stream = avformat_new_stream(file, nullptr);
  avcodec_parameters_from_context(stream->codecpar, codec);
  stream->time_base = codec->time_base;
  EXPECT_GE(avio_open(&file->pb, path.c_str(), AVIO_FLAG_WRITE), 0);
  if (kind.created != nullptr) av_dict_set(&file->metadata, "creation_time", kind.created, 0);
  EXPECT_GE(avformat_write_header(file, nullptr), 0);
  AVFrame* frame = av_frame_alloc();
  frame->width = kWidth;
  frame->height = kHeight;
  frame->format = kind.format;
  EXPECT_GE(av_frame_get_buffer(frame, 0), 0);
  AVPacket* packet = av_packet_alloc();
  for (int i = 0; i <= kind.frames; ++i) {
    if (i < kind.frames) {
      EXPECT_GE(av_frame_make_writable(frame), 0);
      Fill(kind, frame);
      frame->pts = i;
    }
    EXPECT_GE(avcodec_send_frame(codec, i < kind.frames ? frame : nullptr), 0);
    while (avcodec_receive_packet(codec, packet) >= 0) {
      av_packet_rescale_ts(packet, codec->time_base, stream->time_base);
      EXPECT_GE(av_interleaved_write_frame(file, packet), 0);
    }
  }
  EXPECT_GE(av_write_trailer(file), 0);
  av_packet_free(&packet);
  av_frame_free(&frame);
  avcodec_free_context(&codec);
  avio_closep(&file->pb);
  avformat_free_context(file);
  return path;
}

TEST(VideoRemarks, OrdinaryVideoHasNone) {
  EXPECT_THAT(RemarksOnVideos({WriteVideo("ordinary", {})}), IsEmpty());
  EXPECT_THAT(RemarksOnVideos({"/nowhere.mp4"}), IsEmpty());
}

TEST(VideoRemarks, TenBitsAreReadAsEight) {
  const Kind kind{.format = AV_PIX_FMT_YUV420P10};
  const std::string path = WriteVideo("deep", kind);
  EXPECT_THAT(RemarksOnVideos({path}), IsEmpty());
  const auto source = Value(OpenFrameSource(path));
  for (int i = 0; i < kind.frames; ++i) {
    const absl::StatusOr<FrameRead> read = source->Next();
    ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
    const cv::Mat image = std::get<Frame>(*read).image;
    for (int x = 0; x < kWidth; ++x) {
      const double expected = (Brightness(x) - 16.0) * 255.0 / 219.0;
      for (int channel = 0; channel < 3; ++channel) {
        // Half a step of ten bits, and two of the conversion's roundings to eight.
        EXPECT_NEAR(image.at<cv::Vec3b>(kHeight / 2, x)[channel], expected, 2.5) << x;
      }
    }
  }
}

TEST(VideoRemarks, HighDynamicRangeIsTold) {
  Kind kind{.format = AV_PIX_FMT_YUV420P10, .transfer = AVCOL_TRC_SMPTE2084};
  EXPECT_THAT(RemarksOnVideos({WriteVideo("pq", kind)}), ElementsAre(HasSubstr("is HDR (PQ)")));
  kind.transfer = AVCOL_TRC_ARIB_STD_B67;
  EXPECT_THAT(RemarksOnVideos({WriteVideo("hlg", kind)}), ElementsAre(HasSubstr("is HDR (HLG)")));
}

TEST(VideoRemarks, HalfPicturesAreTold) {
  for (const AVFieldOrder fields : {AV_FIELD_TT, AV_FIELD_BB}) {
    EXPECT_THAT(RemarksOnVideos({WriteVideo("interlaced", {.fields = fields})}),
                ElementsAre(HasSubstr("is interlaced")));
  }
}

TEST(VideoRemarks, GapsBetweenChaptersAreTold) {
  const auto chapter = [](const char* name, const char* created) {
    Kind kind{.created = created};
    kind.frames = 50;  // 5 s
    return WriteVideo(name, kind);
  };
  const std::string first = chapter("first", "2026-03-01T10:00:00.000000Z");
  const std::string next = chapter("next", "2026-03-01T10:00:06.000000Z");
  const std::string later = chapter("later", "2026-03-01T10:01:11.000000Z");
  EXPECT_THAT(RemarksOnVideos({first, next}), IsEmpty());
  EXPECT_THAT(RemarksOnVideos({first, next, later}),
              ElementsAre(AllOf(HasSubstr("1 gaps"), HasSubstr("behind " + next),
                                HasSubstr(": 60 s are missing"))));
  EXPECT_THAT(RemarksOnVideos({next, first}), ElementsAre(HasSubstr("was recorded before")));
  EXPECT_THAT(RemarksOnVideos({first, WriteVideo("undated", {}), later}), IsEmpty());
}

}  // namespace
}  // namespace egosieve::vision
