#include "vision/frame/video_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libswscale/swscale.h>
}

#include "absl/strings/str_cat.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/av_input.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/quiet_libraries.h"

namespace egosieve::vision {
namespace {

cv::Mat Turned(const cv::Mat& picture, int degrees) {
  if (degrees == 0 || degrees % 90 != 0) return picture.clone();
  cv::Mat turned;
  cv::rotate(picture, turned, degrees / 90 - 1);  // ROTATE_90_CLOCKWISE is 0
  return turned;
}

struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct FreeDecoder {
  void operator()(AVCodecContext* decoder) const { avcodec_free_context(&decoder); }
};
struct FreeScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};

// The clockwise rotation that the container requests, 0 to 270 degrees.
int DegreesToTurn(const AVStream& stream) {
  const uint8_t* matrix = nullptr;
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(60, 15, 100)
  const AVPacketSideData* data =
      av_packet_side_data_get(stream.codecpar->coded_side_data, stream.codecpar->nb_coded_side_data,
                              AV_PKT_DATA_DISPLAYMATRIX);
  if (data != nullptr && data->size >= 9 * sizeof(int32_t)) matrix = data->data;
#else
  matrix = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
#endif
  if (matrix == nullptr) return 0;
  const double anticlockwise = av_display_rotation_get(reinterpret_cast<const int32_t*>(matrix));
  if (!std::isfinite(anticlockwise)) return 0;
  return static_cast<int>((360 - std::lround(anticlockwise) % 360) % 360);
}

// The size of a file; the same number for all inputs that are not files.
std::uintmax_t SizeOf(const std::string& path) {
  std::error_code error;
  return std::filesystem::file_size(path, error);
}

// Decoded pictures as 8-bit BGR, converted as the program ffmpeg converts them: by the matrix and
// range that each picture names, whatever its size and format.
class BgrConverter {
 public:
  // Empty if libswscale cannot convert it. The result is valid until the next call.
  cv::Mat Convert(const AVFrame& frame) {
    const auto format = static_cast<AVPixelFormat>(frame.format);
    const Kind kind{frame.width, frame.height, frame.format, frame.colorspace, frame.color_range};
    if (scaler_ == nullptr || !(kind == kind_)) {
      scaler_.reset(sws_getContext(frame.width, frame.height, format, frame.width, frame.height,
                                   AV_PIX_FMT_BGR24, SWS_BICUBIC, nullptr, nullptr, nullptr));
      if (scaler_ == nullptr) return {};
      SetColours(frame);
      kind_ = kind;
    }
    // libswscale writes whole vectors beyond the end of a row.
    constexpr int kAligned = 64;
    const int step = (3 * frame.width + 2 * kAligned - 1) / kAligned * kAligned;
    pixels_.create(frame.height + 1, step, CV_8U);
    uint8_t* rows[4] = {pixels_.data};
    const int steps[4] = {step};
    if (sws_scale(scaler_.get(), frame.data, frame.linesize, 0, frame.height, rows, steps) !=
        frame.height) {
      return {};
    }
    return {frame.height, frame.width, CV_8UC3, pixels_.data, static_cast<size_t>(step)};
  }

 private:
  struct Kind {
    int width = 0, height = 0, format = -1, matrix = 0, range = 0;
    bool operator==(const Kind&) const = default;
  };

  void SetColours(const AVFrame& frame) {
    int *matrix = nullptr, *to = nullptr;
    int full = 0, to_full = 0, brightness = 0, contrast = 0, saturation = 0;
    if (sws_getColorspaceDetails(scaler_.get(), &matrix, &full, &to, &to_full, &brightness,
                                 &contrast, &saturation) < 0) {
      return;  // not from YUV
    }
    const int* from =
        frame.colorspace == AVCOL_SPC_UNSPECIFIED ? matrix : sws_getCoefficients(frame.colorspace);
    if (frame.color_range != AVCOL_RANGE_UNSPECIFIED) full = frame.color_range == AVCOL_RANGE_JPEG;
    sws_setColorspaceDetails(scaler_.get(), from, full, to, to_full, brightness, contrast,
                             saturation);
  }

  std::unique_ptr<SwsContext, FreeScaler> scaler_;
  Kind kind_;
  cv::Mat pixels_;
};

// Up to this distance, frames are decoded and dropped instead of jumped over.
constexpr int64_t kFar = 64;
// A jump goes to a key frame at least so many frames before the one that is needed: the first
// frames behind a key frame may refer to frames before it.
constexpr int64_t kBefore = 16;
// The longest time that a stream may take to open or be silent.
constexpr int kStreamTimeoutSeconds = 10;

class VideoFile : public FrameSource {
 public:
  VideoFile(std::string path, double nominal_rate_hz, bool is_live = false)
      : path_(std::move(path)),
        rate_hz_(nominal_rate_hz),
        is_live_(is_live),
        bytes_(SizeOf(path_)),
        has_looked_for_index_(is_live) {}

  absl::Status Open() {
    input_ = AvInput::Open(path_, is_live_ ? kStreamTimeoutSeconds : 0);
    decoder_.reset();
    const AVCodec* codec =
        input_ == nullptr ? nullptr : avcodec_find_decoder(input_->video()->codecpar->codec_id);
    if (codec != nullptr) decoder_.reset(avcodec_alloc_context3(codec));
    if (decoder_ == nullptr ||
        avcodec_parameters_to_context(decoder_.get(), input_->video()->codecpar) < 0) {
      return NoVideo();
    }
    const AVStream& video = *input_->video();
    if (const absl::Status size = CheckPixels(decoder_->width, decoder_->height); !size.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(path_, ": ", size.message()));
    }
    decoder_->pkt_timebase = video.time_base;
    decoder_->thread_count = kernels::MaximumThreads();
    if (avcodec_open2(decoder_.get(), codec, nullptr) < 0) return NoVideo();
    degrees_ = DegreesToTurn(video);
    const double rate = av_q2d(av_guess_frame_rate(input_->context(), input_->video(), nullptr));
    if (rate > 0.0 && rate < 1e6) rate_hz_ = rate;
    if (expected_frame_count_ < 0 && !is_live_) expected_frame_count_ = CountSaid(video);
    start_ = video.start_time;
    position_ = 0;
    ended_ = is_drained_ = has_jumped_ = has_other_times_ = is_cut_short_ = false;
    return absl::OkStatus();
  }

  absl::StatusOr<FrameRead> Next() override {
    if (!has_looked_for_index_) index_ = VideoIndex::Read(path_);
    has_looked_for_index_ = true;
    if (next_index_ - position_ > kFar) EGOSIEVE_RETURN_IF_ERROR(Approach(next_index_));
    GrabUntil(next_index_);
    if (has_jumped_ && (has_other_times_ || (ended_ && position_ != index_->size()))) {
      may_jump_ = false;
      EGOSIEVE_RETURN_IF_ERROR(Open());
      GrabUntil(next_index_);
    }
    if (position_ <= next_index_) return FrameRead(End());
    const int64_t index = next_index_++;
    if (index < position_ - 1) return FrameRead(DamagedFrame{index, CannotBeDecoded(index)});
    return Retrieve(index);
  }

  absl::StatusOr<bool> DeliversAFrame() {
    const bool delivers = Grab();
    EGOSIEVE_RETURN_IF_ERROR(Open());
    return delivers;
  }

  absl::Status SeekTo(int64_t index) override {
    if (index < 0) return absl::InvalidArgumentError(absl::StrCat("frame index ", index, " < 0"));
    const bool is_held = index == position_ - 1 && !ended_;  // in frame_
    if (is_live_ && index < position_ && !is_held) {
      return absl::FailedPreconditionError(
          absl::StrCat(description(), ": a stream cannot be gone back to; record it"));
    }
    // Next approaches frames far from the beginning.
    if (index < position_ && !is_held) EGOSIEVE_RETURN_IF_ERROR(Open());
    next_index_ = index;
    return absl::OkStatus();
  }

  int64_t next_index() const override { return next_index_; }
  int64_t expected_frame_count() const override { return expected_frame_count_; }
  std::vector<std::string> files() const override {
    return is_live_ ? std::vector<std::string>() : std::vector{path_};
  }
  std::string description() const override { return is_live_ ? WithoutCredentials(path_) : path_; }

 private:
  absl::Status NoVideo() const {
    if (!is_live_ && LacksSampleTable(path_)) {
      return absl::InvalidArgumentError(absl::StrCat(
          path_,
          ": cut short: the recording was never closed and has no table of its frames; a repair "
          "program such as untrunc may recover it"));
    }
    return absl::InvalidArgumentError(
        absl::StrCat(path_,
                     ": not a video that FFmpeg can decode; give a video file, a folder of "
                     "pictures or a glob"));
  }

  // What the header says, or its duration; -1 if it says neither.
  int64_t CountSaid(const AVStream& video) const {
    if (video.nb_frames > 0) return video.nb_frames;
    const int64_t duration = input_->context()->duration;
    if (duration <= 0 || duration == AV_NOPTS_VALUE) return -1;
    const double count = static_cast<double>(duration) / AV_TIME_BASE * rate_hz_;
    return count >= 1.0 && count < 1e9 ? std::llround(count) : -1;
  }

  // Jumps to a key frame before a frame far ahead, or before the last one, if the video has an
  // index; else does nothing.
  absl::Status Approach(int64_t index) {
    if (!index_ || !may_jump_) return absl::OkStatus();
    const int64_t wanted = index_->KeyOf(std::min(index, index_->size() - 1));
    const int64_t key = index_->KeyOf(std::max<int64_t>(wanted - kBefore, 0));
    if (key <= position_ + kFar) return absl::OkStatus();
    has_jumped_ = true;
    if (!input_->SeekTo(index_->time(key))) return Open();
    avcodec_flush_buffers(decoder_.get());
    is_drained_ = ended_ = false;
    if (Grab() && !has_other_times_ && position_ <= wanted) return absl::OkStatus();
    return Open();
  }

  void GrabUntil(int64_t index) {
    while (position_ <= index && Grab()) {
    }
  }

  // Decodes the next picture into frame_; false at the end.
  bool Grab() {
    if (ended_ || frame_ == nullptr || packet_ == nullptr) return false;
    while (true) {
      const int code = avcodec_receive_frame(decoder_.get(), frame_.get());
      if (code >= 0) break;
      if (code == AVERROR_EOF || is_drained_) {
        ended_ = true;
        return false;
      }
      Feed();
    }
    const int64_t index = IndexGrabbed();
    seconds_ = Seconds(index);
    position_ = index + 1;
    return true;
  }

  // Gives the decoder the next packet, or at the end none. Packets that it refuses are left out.
  void Feed() {
    const int code = input_->Read(packet_.get());
    if (code < 0) {
      is_cut_short_ |= code != AVERROR_EOF;
      is_drained_ = true;
      avcodec_send_packet(decoder_.get(), nullptr);
      return;
    }
    ends_within_a_packet_ = (packet_->flags & AV_PKT_FLAG_CORRUPT) != 0;
    avcodec_send_packet(decoder_.get(), packet_.get());
  }

  // Frames that cannot be decoded are not delivered, and those after them keep their index. If a
  // frame's time is not that of a packet, a video that is read from its beginning is counted from
  // there on.
  int64_t IndexGrabbed() {
    if (!index_) return position_;
    const std::optional<int64_t> index = index_->FrameAt(frame_->best_effort_timestamp);
    if (index && *index >= position_) return *index;
    has_other_times_ = has_jumped_;
    if (!has_jumped_) index_.reset();
    return position_;
  }

  // The time of the frame that was just grabbed: its own where that is later than the last one's.
  double Seconds(int64_t index) {
    const int64_t time = frame_->best_effort_timestamp;
    const double following = index == 0 ? 0.0 : seconds_ + 1.0 / rate_hz_;
    if (time == AV_NOPTS_VALUE) return following;
    if (start_ == AV_NOPTS_VALUE) start_ = time;
    const double own = static_cast<double>(time - start_) * av_q2d(input_->video()->time_base);
    return index_ || index == 0 || own > seconds_ ? own : following;
  }

  FrameRead Retrieve(int64_t index) {
    if (const absl::Status size = CheckPixels(frame_->width, frame_->height); !size.ok()) {
      return DamagedFrame{index, std::string(size.message())};
    }
    const cv::Mat picture = converter_.Convert(*frame_);
    if (picture.empty()) return DamagedFrame{index, CannotBeDecoded(index)};
    return Frame{index, seconds_, Turned(picture, degrees_)};
  }

  std::string CannotBeDecoded(int64_t index) const {
    return absl::StrCat(description(), ": frame ", index, " cannot be decoded");
  }

  EndOfFrames End() const {
    EndOfFrames end{position_, "", position_ > 0 ? seconds_ + 1.0 / rate_hz_ : 0.0};
    if (is_live_) return end;  // a length in the header does not count
    if (SizeOf(path_) != bytes_) {
      end.warning = absl::StrCat(path_, ": changed while it was read; read it again once it stays");
    } else if (is_cut_short_ || ends_within_a_packet_ || EndsWithinAPart(path_)) {
      end.warning = absl::StrCat(path_, ": cut short; it ended after ", position_, " frames");
    }
    return end;
  }

  const std::string path_;
  double rate_hz_;              // nominal; the stream's own once it is open
  const bool is_live_;          // a stream
  const std::uintmax_t bytes_;  // when first opened
  std::unique_ptr<AvInput> input_;
  std::unique_ptr<AVCodecContext, FreeDecoder> decoder_;
  const Packet packet_{av_packet_alloc()};
  const std::unique_ptr<AVFrame, FreeFrame> frame_{av_frame_alloc()};  // the last grabbed
  BgrConverter converter_;
  int64_t expected_frame_count_ = -1;
  int degrees_ = 0;         // clockwise rotation applied to pictures
  int64_t start_ = 0;       // the stream's first time, in units of its time base
  double seconds_ = 0.0;    // of the last frame grabbed
  int64_t position_ = 0;    // index after the last frame grabbed
  int64_t next_index_ = 0;  // returned by Next(); ahead of position_ after a seek
  bool ended_ = false;
  bool is_drained_ = false;  // no packets are left
  bool is_cut_short_ = false, ends_within_a_packet_ = false;
  bool has_looked_for_index_;
  bool has_jumped_ = false, has_other_times_ = false;  // since the video was opened
  bool may_jump_ = true;
  std::optional<VideoIndex> index_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameSource>> OpenVideoFile(const std::string& path,
                                                           const FrameSourceOptions& options) {
  QuietLibraries();
  auto video = std::make_unique<VideoFile>(path, options.nominal_rate_hz);
  EGOSIEVE_RETURN_IF_ERROR(video->Open());
  EGOSIEVE_ASSIGN_OR_RETURN(const bool delivers, video->DeliversAFrame());
  if (!delivers) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": opens as a video but delivers no frame; check that it plays"));
  }
  return std::unique_ptr<FrameSource>(std::move(video));
}

absl::Status CheckWrittenVideo(const std::string& path, int64_t frames) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool is_synced = descriptor >= 0 && fsync(descriptor) == 0;
  if (descriptor >= 0 && close(descriptor) == 0 && is_synced) {
    const absl::StatusOr<std::unique_ptr<FrameSource>> video = OpenVideoFile(path, {});
    if (video.ok() && (*video)->expected_frame_count() == frames) return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(absl::StrCat(
      "cannot write the video ", path, " with all of its ", frames, " frames; free some space"));
}

bool IsStreamAddress(const std::string& input) {
  size_t i = 0;
  while (i < input.size() && (std::isalnum(static_cast<unsigned char>(input[i])) != 0)) ++i;
  return i > 1 && input.compare(i, 3, "://") == 0;
}

std::string WithoutCredentials(const std::string& address) {
  const size_t host = address.find("://") + 3;
  const size_t at = address.find('@', host);
  if (at == std::string::npos || address.find('/', host) < at) return address;
  return absl::StrCat(address.substr(0, host), address.substr(at + 1));
}

absl::StatusOr<std::unique_ptr<FrameSource>> OpenLiveStream(const std::string& address) {
  QuietLibraries();
  auto stream = std::make_unique<VideoFile>(address, FrameSourceOptions().nominal_rate_hz, true);
  if (!stream->Open().ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(stream->description(),
                     ": no stream that FFmpeg can open; check the address, and that the "
                     "sender runs"));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const FrameRead first, stream->Next());
  if (!std::holds_alternative<Frame>(first)) {
    return absl::InvalidArgumentError(absl::StrCat(
        stream->description(), ": opens as a stream but delivers no frame; check that it plays"));
  }
  EGOSIEVE_RETURN_IF_ERROR(stream->SeekTo(0));
  return std::unique_ptr<FrameSource>(std::move(stream));
}

}  // namespace egosieve::vision
