#include "vision/frame/video_file.h"

#include <cmath>
#include <opencv2/videoio.hpp>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/image_decoding.h"
#include "vision/frame/pixel_limit.h"
#include "vision/frame/quiet_libraries.h"

namespace egosieve::vision {
namespace {

class VideoFile : public FrameSource {
 public:
  VideoFile(std::string path, double nominal_rate_hz)
      : path_(std::move(path)), nominal_rate_hz_(nominal_rate_hz) {}

  absl::Status Open() {
    try {
      capture_.open(path_, cv::CAP_FFMPEG);
      if (!capture_.isOpened()) {
        return absl::InvalidArgumentError(
            absl::StrCat(path_,
                         ": not a video that FFmpeg can decode; give a video file, a folder of "
                         "pictures or a glob"));
      }
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
    return absl::OkStatus();
  }

  absl::StatusOr<FrameRead> Next() override {
    while (position_ < next_index_ && Grab()) {
    }
    if (position_ < next_index_ || !Grab()) return FrameRead(End());
    const int64_t index = next_index_++;
    absl::StatusOr<Frame> frame = Retrieve(index);
    if (!frame.ok()) return FrameRead(DamagedFrame{index, std::string(frame.status().message())});
    return FrameRead(*std::move(frame));
  }

  absl::Status SeekTo(int64_t index) override {
    if (index < 0) return absl::InvalidArgumentError(absl::StrCat("frame index ", index, " < 0"));
    if (index < position_) EGOSIEVE_RETURN_IF_ERROR(Open());
    next_index_ = index;
    return absl::OkStatus();
  }

  int64_t next_index() const override { return next_index_; }
  int64_t expected_frame_count() const override { return expected_frame_count_; }
  std::string description() const override { return path_; }

 private:
  bool Grab() {
    if (ended_) return false;
    try {
      ended_ = !capture_.grab();
    } catch (const cv::Exception&) {
      ended_ = true;
    }
    if (!ended_) ++position_;
    return !ended_;
  }

  absl::StatusOr<Frame> Retrieve(int64_t index) {
    cv::Mat picture;
    double milliseconds = 0.0;
    try {
      capture_.retrieve(picture);
      milliseconds = capture_.get(cv::CAP_PROP_POS_MSEC);
    } catch (const cv::Exception&) {
      picture.release();
    }
    if (picture.empty()) {
      return absl::DataLossError(absl::StrCat(path_, ": frame ", index, " cannot be decoded"));
    }
    // The decoder reuses its buffer for the next frame.
    absl::StatusOr<DecodedImage> decoded = ConvertToBgr(picture.clone());
    if (!decoded.ok()) return decoded.status();
    const double nominal_seconds = static_cast<double>(index) / nominal_rate_hz_;
    Frame frame;
    frame.index = index;
    frame.time_seconds = index > 0 && !(milliseconds > 0) ? nominal_seconds : milliseconds / 1000.0;
    frame.image = decoded->image;
    frame.is_grey = decoded->is_grey;
    return frame;
  }

  EndOfFrames End() const {
    EndOfFrames end{position_, ""};
    if (expected_frame_count_ > position_) {
      end.warning =
          absl::StrCat(path_, ": ended after ", position_, " frames where its header says ",
                       expected_frame_count_, "; it may be cut short");
    }
    return end;
  }

  const std::string path_;
  double nominal_rate_hz_;
  cv::VideoCapture capture_;
  int64_t expected_frame_count_ = -1;
  int64_t position_ = 0;    // frames grabbed so far: the stream's own next index
  int64_t next_index_ = 0;  // that Next() returns; ahead of position_ after a seek
  bool ended_ = false;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameSource>> OpenVideoFile(const std::string& path,
                                                           const FrameSourceOptions& options) {
  QuietLibraries();
  auto video = std::make_unique<VideoFile>(path, options.nominal_rate_hz);
  EGOSIEVE_RETURN_IF_ERROR(video->Open());
  EGOSIEVE_ASSIGN_OR_RETURN(const FrameRead first, video->Next());
  if (std::holds_alternative<EndOfFrames>(first)) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": opens as a video but delivers no frame; check that it plays"));
  }
  EGOSIEVE_RETURN_IF_ERROR(video->SeekTo(0));
  return std::unique_ptr<FrameSource>(std::move(video));
}

}  // namespace egosieve::vision
