#include "vision/frame/video_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <opencv2/videoio.hpp>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/pixel_limit.h"
#include "vision/frame/quiet_libraries.h"

namespace egosieve::vision {
namespace {

// The clockwise rotation that the container requests, 0 to 270 degrees. OpenCV 4.6 alone has it
// with the wrong sign (its issue 22088), and so turns phone video upside down.
int DegreesToTurn(const cv::VideoCapture& capture) {
  const auto degrees = static_cast<int>(capture.get(cv::CAP_PROP_ORIENTATION_META));
  constexpr bool kIsInverted = CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR == 6;
  return (kIsInverted ? 360 - degrees % 360 : 360 + degrees) % 360;
}

cv::Mat Turned(const cv::Mat& picture, int degrees) {
  constexpr cv::RotateFlags kTurns[] = {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180,
                                        cv::ROTATE_90_COUNTERCLOCKWISE};
  if (degrees == 0 || degrees % 90 != 0) return picture.clone();
  cv::Mat turned;
  cv::rotate(picture, turned, kTurns[degrees / 90 - 1]);
  return turned;
}

// The positions of the frames of a video, read from its packets without decoding.
//
//   frame k     the packet with the k-th smallest presentation time                        (VI1)
//   key of k    the last key frame not after frame k: decoding from there gives the same frame k
//               as decoding from the beginning                                             (VI2)
//
// A decoder delivers (VI1) only if each packet has a presentation time of its own, is to be shown
// and is complete, and if the first packet is a key frame and the first to be shown. Other videos
// have no index. Cost: the file is read once.
class VideoIndex {
 public:
  // The index of the stream that a player would show; nothing without a reliable one.
  static std::optional<VideoIndex> Read(const std::string& path);

  int64_t size() const { return static_cast<int64_t>(seconds_.size()); }
  // The time of a frame since the stream's start.
  double seconds(int64_t frame) const { return seconds_[frame]; }
  int64_t KeyOf(int64_t frame) const;
  // The frame with this time; nothing if none is within a quarter of the distance to its
  // neighbours.
  std::optional<int64_t> FrameAt(double seconds) const;

 private:
  std::vector<double> seconds_;  // of each frame, ascending
  std::vector<int64_t> keys_;    // frames, ascending; the first is 0
};

struct CloseInput {
  void operator()(AVFormatContext* context) const { avformat_close_input(&context); }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};

struct Entry {
  int64_t time;  // in units of the stream's time base
  bool is_key;
};

// In the order of the file; empty if one of them is not reliable.
std::vector<Entry> ReadEntries(AVFormatContext* context, int stream) {
  const std::unique_ptr<AVPacket, FreePacket> packet(av_packet_alloc());
  std::vector<Entry> entries;
  int code = 0;
  while (packet != nullptr && (code = av_read_frame(context, packet.get())) >= 0) {
    if (packet->stream_index == stream) {
      if (packet->pts == AV_NOPTS_VALUE ||
          (packet->flags & (AV_PKT_FLAG_CORRUPT | AV_PKT_FLAG_DISCARD)) != 0) {
        return {};
      }
      entries.push_back({packet->pts, (packet->flags & AV_PKT_FLAG_KEY) != 0});
    }
    av_packet_unref(packet.get());
  }
  if (code != AVERROR_EOF) entries.clear();
  return entries;
}

std::optional<VideoIndex> VideoIndex::Read(const std::string& path) {
  AVFormatContext* opened = nullptr;
  if (avformat_open_input(&opened, path.c_str(), nullptr, nullptr) < 0) return std::nullopt;
  const std::unique_ptr<AVFormatContext, CloseInput> context(opened);
  if (avformat_find_stream_info(opened, nullptr) < 0) return std::nullopt;
  const int stream = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (stream < 0) return std::nullopt;
  for (unsigned i = 0; i < opened->nb_streams; ++i) {
    if (static_cast<int>(i) != stream) opened->streams[i]->discard = AVDISCARD_ALL;
  }
  std::vector<Entry> entries = ReadEntries(opened, stream);
  if (entries.empty() || !entries.front().is_key) return std::nullopt;
  const int64_t first_time = entries.front().time;
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.time < b.time; });
  if (entries.front().time != first_time) return std::nullopt;
  const auto twice =
      std::adjacent_find(entries.begin(), entries.end(),
                         [](const Entry& a, const Entry& b) { return a.time == b.time; });
  if (twice != entries.end()) return std::nullopt;
  const AVStream& of = *opened->streams[stream];
  const int64_t start = of.start_time == AV_NOPTS_VALUE ? first_time : of.start_time;
  VideoIndex index;
  for (const Entry& entry : entries) {
    if (entry.is_key) index.keys_.push_back(index.size());
    index.seconds_.push_back(static_cast<double>(entry.time - start) * av_q2d(of.time_base));
  }
  return index;
}

int64_t VideoIndex::KeyOf(int64_t frame) const {
  return *(std::upper_bound(keys_.begin(), keys_.end(), frame) - 1);
}

std::optional<int64_t> VideoIndex::FrameAt(double seconds) const {
  const auto behind = std::lower_bound(seconds_.begin(), seconds_.end(), seconds);
  int64_t nearest = std::min<int64_t>(behind - seconds_.begin(), size() - 1);
  if (nearest > 0 && seconds - seconds_[nearest - 1] < std::abs(seconds_[nearest] - seconds)) {
    --nearest;
  }
  constexpr double kShare = 0.25;
  const double distance = std::abs(seconds_[nearest] - seconds);
  for (const int64_t neighbour : {nearest - 1, nearest + 1}) {
    if (neighbour < 0 || neighbour >= size()) continue;
    if (distance > kShare * std::abs(seconds_[neighbour] - seconds_[nearest])) return std::nullopt;
  }
  return nearest;
}

// The size of a file; the same number for all inputs that are not files.
std::uintmax_t SizeOf(const std::string& path) {
  std::error_code error;
  return std::filesystem::file_size(path, error);
}

// Up to this distance, frames are decoded and dropped instead of jumped over.
constexpr int64_t kFar = 64;

class VideoFile : public FrameSource {
 public:
  // timeout_seconds: for a stream; 0: no timeout.
  VideoFile(std::string path, double nominal_rate_hz, int timeout_seconds = 0)
      : path_(std::move(path)),
        nominal_rate_hz_(nominal_rate_hz),
        timeout_seconds_(timeout_seconds),
        bytes_(SizeOf(path_)),
        has_looked_for_index_(timeout_seconds > 0) {}

  absl::Status Open() {
    try {
      std::vector<int> parameters;
      if (timeout_seconds_ > 0) {
        const int milliseconds = 1000 * timeout_seconds_;
        parameters = {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, milliseconds,  //
                      cv::CAP_PROP_READ_TIMEOUT_MSEC, milliseconds};
      }
      capture_.open(path_, cv::CAP_FFMPEG, parameters);
      if (!capture_.isOpened()) {
        return absl::InvalidArgumentError(
            absl::StrCat(path_,
                         ": not a video that FFmpeg can decode; give a video file, a folder of "
                         "pictures or a glob"));
      }
      capture_.set(cv::CAP_PROP_ORIENTATION_AUTO, 0.0);
      degrees_ = DegreesToTurn(capture_);
      if (const absl::Status size =
              CheckPixels(std::llround(capture_.get(cv::CAP_PROP_FRAME_WIDTH)),
                          std::llround(capture_.get(cv::CAP_PROP_FRAME_HEIGHT)));
          !size.ok()) {
        return absl::InvalidArgumentError(absl::StrCat(path_, ": ", size.message()));
      }
      const double count = capture_.get(cv::CAP_PROP_FRAME_COUNT);
      if (count >= 1 && count < 1e9) expected_frame_count_ = std::llround(count);
      const double rate = capture_.get(cv::CAP_PROP_FPS);
      if (rate > 0 && rate < 1e6) nominal_rate_hz_ = rate;
    } catch (const cv::Exception& error) {
      return absl::InvalidArgumentError(
          absl::StrCat(path_, ": cannot be opened (", error.err, ")"));
    }
    position_ = 0;
    ended_ = false;
    has_jumped_ = has_other_times_ = false;
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
    absl::StatusOr<Frame> frame = Retrieve(index);
    if (!frame.ok()) return FrameRead(DamagedFrame{index, std::string(frame.status().message())});
    return FrameRead(*std::move(frame));
  }

  absl::StatusOr<bool> DeliversAFrame() {
    const bool delivers = Grab();
    EGOSIEVE_RETURN_IF_ERROR(Open());
    return delivers;
  }

  absl::Status SeekTo(int64_t index) override {
    if (index < 0) return absl::InvalidArgumentError(absl::StrCat("frame index ", index, " < 0"));
    // Next approaches frames far from the beginning.
    if (index < position_) EGOSIEVE_RETURN_IF_ERROR(Open());
    next_index_ = index;
    return absl::OkStatus();
  }

  int64_t next_index() const override { return next_index_; }
  int64_t expected_frame_count() const override { return expected_frame_count_; }
  std::vector<std::string> files() const override { return {path_}; }
  std::string description() const override { return path_; }

 private:
  // Jumps to a key frame before a frame far ahead, or before the last one, if the video has an
  // index; else does nothing.
  absl::Status Approach(int64_t index) {
    if (!index_ || !may_jump_) return absl::OkStatus();
    const int64_t key = index_->KeyOf(std::min(index, index_->size() - 1));
    if (key <= position_ + kFar) return absl::OkStatus();
    has_jumped_ = true;
    return JumpBefore(key) ? absl::OkStatus() : Open();
  }

  // Grabs one of the kFar frames before `key`; false if that fails. OpenCV seeks by time, to a key
  // frame at least 16 frames before the requested one. So the delivered frames do not include
  // frames that precede their key frame in presentation and refer to frames before it.
  bool JumpBefore(int64_t key) {
    const double wanted = std::floor(index_->seconds(key) * nominal_rate_hz_) - 2.0;
    try {
      if (!(wanted > 0.0) || !capture_.set(cv::CAP_PROP_POS_FRAMES, wanted)) return false;
    } catch (const cv::Exception&) {
      return false;
    }
    ended_ = false;
    return Grab() && !has_other_times_ && position_ <= key && position_ > key - kFar;
  }

  void GrabUntil(int64_t index) {
    while (position_ <= index && Grab()) {
    }
  }

  bool Grab() {
    for (int64_t attempts = AttemptsToGrab(); !ended_ && attempts > 0; --attempts) {
      try {
        if (!capture_.grab()) continue;
      } catch (const cv::Exception&) {
        ended_ = true;
        break;
      }
      const int64_t index = IndexGrabbed();
      seconds_ = Seconds(index);
      position_ = index + 1;
      return true;
    }
    ended_ = true;
    return false;
  }

  // For callers of OpenCV a packet that cannot be decoded looks like the end; the next call
  // continues after it.
  int64_t AttemptsToGrab() const {
    if (timeout_seconds_ > 0) return 1;
    return index_ ? std::max<int64_t>(index_->size() - position_, 1) : kFar;
  }

  // Frames that cannot be decoded are not delivered, and those after them keep their index. If a
  // frame's time is not that of a packet, a video that is read from its beginning is counted from
  // there on.
  int64_t IndexGrabbed() {
    if (!index_) return position_;
    const std::optional<int64_t> index =
        index_->FrameAt(capture_.get(cv::CAP_PROP_POS_MSEC) / 1000.0);
    if (index && *index >= position_) return *index;
    has_other_times_ = has_jumped_;
    if (!has_jumped_) index_.reset();
    return position_;
  }

  // The time of the frame that was just grabbed.
  double Seconds(int64_t index) {
    const double milliseconds = capture_.get(cv::CAP_PROP_POS_MSEC);
    return index > 0 && !(milliseconds > 0) ? static_cast<double>(index) / nominal_rate_hz_
                                            : milliseconds / 1000.0;
  }

  absl::StatusOr<Frame> Retrieve(int64_t index) {
    cv::Mat picture;
    try {
      capture_.retrieve(picture);
    } catch (const cv::Exception&) {
      picture.release();
    }
    if (picture.empty()) {
      return absl::DataLossError(CannotBeDecoded(index));
    }
    // The decoder reuses its buffer for the next frame.
    absl::StatusOr<DecodedImage> decoded = ConvertToBgr(Turned(picture, degrees_));
    if (!decoded.ok()) return decoded.status();
    Frame frame;
    frame.index = index;
    frame.time_seconds = seconds_;
    frame.image = decoded->image;
    frame.is_grey = decoded->is_grey;
    return frame;
  }

  std::string CannotBeDecoded(int64_t index) const {
    return absl::StrCat(path_, ": frame ", index, " cannot be decoded");
  }

  EndOfFrames End() const {
    EndOfFrames end{position_, "", position_ > 0 ? seconds_ + 1.0 / nominal_rate_hz_ : 0.0};
    if (expected_frame_count_ > position_) {
      end.warning =
          absl::StrCat(path_, ": ended after ", position_, " frames where its header says ",
                       expected_frame_count_, "; it may be cut short");
    } else if (SizeOf(path_) != bytes_) {
      end.warning = absl::StrCat(path_, ": changed while it was read; read it again once it stays");
    }
    return end;
  }

  const std::string path_;
  double nominal_rate_hz_;
  const int timeout_seconds_;
  const std::uintmax_t bytes_;  // when first opened
  cv::VideoCapture capture_;
  int64_t expected_frame_count_ = -1;
  int degrees_ = 0;         // clockwise rotation applied to pictures
  double seconds_ = 0.0;    // of the last frame grabbed
  int64_t position_ = 0;    // index after the last frame grabbed
  int64_t next_index_ = 0;  // returned by Next(); ahead of position_ after a seek
  bool ended_ = false;
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

absl::StatusOr<std::unique_ptr<FrameSource>> OpenStreamAsVideo(const std::string& address) {
  QuietLibraries();
  auto video = std::make_unique<VideoFile>(address, FrameSourceOptions().nominal_rate_hz,
                                           kStreamTimeoutSeconds);
  EGOSIEVE_RETURN_IF_ERROR(video->Open());
  return std::unique_ptr<FrameSource>(std::move(video));
}

}  // namespace egosieve::vision
