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

// The clockwise turn by which the container wants its pictures shown, 0 to 270 degrees. OpenCV 4.6
// alone has it the wrong way round (its issue 22088), and so turns phone video upside down.
int DegreesToTurn(const cv::VideoCapture& capture) {
  const auto degrees = static_cast<int>(capture.get(cv::CAP_PROP_ORIENTATION_META));
  constexpr bool kIsInverted = CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR == 6;
  return (kIsInverted ? 360 - degrees % 360 : 360 + degrees) % 360;
}

cv::Mat Turned(const cv::Mat& picture, int degrees) {
  cv::Mat turned;
  switch (degrees) {
    case 90:
      cv::rotate(picture, turned, cv::ROTATE_90_CLOCKWISE);
      return turned;
    case 180:
      cv::rotate(picture, turned, cv::ROTATE_180);
      return turned;
    case 270:
      cv::rotate(picture, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
      return turned;
    default:
      return picture.clone();
  }
}

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
  std::vector<std::string> files() const override { return {path_}; }
  std::string description() const override { return path_; }

 private:
  bool Grab() {
    if (ended_) return false;
    try {
      ended_ = !capture_.grab();
    } catch (const cv::Exception&) {
      ended_ = true;
    }
    if (ended_) return false;
    seconds_ = Seconds(position_++);
    return true;
  }

  // Of the frame that was just grabbed.
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
      return absl::DataLossError(absl::StrCat(path_, ": frame ", index, " cannot be decoded"));
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

  EndOfFrames End() const {
    EndOfFrames end{position_, "", position_ > 0 ? seconds_ + 1.0 / nominal_rate_hz_ : 0.0};
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
  int degrees_ = 0;         // by which pictures are turned, clockwise
  double seconds_ = 0.0;    // of the last frame grabbed
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
