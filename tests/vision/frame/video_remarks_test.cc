// Videos as phones and old cameras make them, written by FFmpeg's own encoder: what is read of
// them, and what is said of them.
#include "vision/frame/video_remarks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "tests/testing/status.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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
  Kind kind;
  kind.format = AV_PIX_FMT_YUV420P10;
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
  Kind kind;
  kind.format = AV_PIX_FMT_YUV420P10;
  kind.transfer = AVCOL_TRC_SMPTE2084;
  EXPECT_THAT(RemarksOnVideos({WriteVideo("pq", kind)}), ElementsAre(HasSubstr("is HDR (PQ)")));
  kind.transfer = AVCOL_TRC_ARIB_STD_B67;
  EXPECT_THAT(RemarksOnVideos({WriteVideo("hlg", kind)}), ElementsAre(HasSubstr("is HDR (HLG)")));
}

TEST(VideoRemarks, HalfPicturesAreTold) {
  for (const AVFieldOrder fields : {AV_FIELD_TT, AV_FIELD_BB}) {
    Kind kind;
    kind.fields = fields;
    EXPECT_THAT(RemarksOnVideos({WriteVideo("interlaced", kind)}),
                ElementsAre(HasSubstr("is interlaced")));
  }
}

TEST(VideoRemarks, GapsBetweenChaptersAreTold) {
  const auto chapter = [](const char* name, const char* created) {
    Kind kind;
    kind.created = created;
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
