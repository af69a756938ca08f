#include "vision/frame/live_stream.h"

#include <cctype>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/video_file.h"

namespace egosieve::vision {
namespace {

class LiveStream : public FrameSource {
 public:
  LiveStream(std::unique_ptr<FrameSource> video, std::string description)
      : video_(std::move(video)), description_(std::move(description)) {}

  absl::StatusOr<FrameRead> Next() override {
    if (std::exchange(again_, false)) return FrameRead(*last_);
    EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, video_->Next());
    if (auto* end = std::get_if<EndOfFrames>(&read)) {
      end->warning.clear();  // a length in the header does not count
    } else if (const auto* frame = std::get_if<Frame>(&read)) {
      last_ = *frame;
    } else {
      last_.reset();
    }
    return read;
  }

  absl::Status SeekTo(int64_t index) override {
    again_ = last_.has_value() && index == last_->index;
    while (!again_ && video_->next_index() < index) {
      EGOSIEVE_ASSIGN_OR_RETURN(const FrameRead read, Next());
      if (std::holds_alternative<EndOfFrames>(read)) break;
    }
    if (again_ || video_->next_index() <= index) return absl::OkStatus();
    return absl::FailedPreconditionError(
        absl::StrCat(description_, ": a stream cannot be gone back to; record it"));
  }

  int64_t next_index() const override { return video_->next_index() - (again_ ? 1 : 0); }
  int64_t expected_frame_count() const override { return -1; }
  std::string description() const override { return description_; }

 private:
  std::unique_ptr<FrameSource> video_;
  std::string description_;
  std::optional<Frame> last_;  // the last delivered frame
  bool again_ = false;         // Next() delivers last_ again
};

}  // namespace

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
  const std::string name = WithoutCredentials(address);
  absl::StatusOr<std::unique_ptr<FrameSource>> video = OpenStreamAsVideo(address);
  if (!video.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(name,
                     ": no stream that FFmpeg can open; check the address, and that the "
                     "sender runs"));
  }
  auto stream = std::make_unique<LiveStream>(*std::move(video), name);
  EGOSIEVE_ASSIGN_OR_RETURN(const FrameRead first, stream->Next());
  if (!std::holds_alternative<Frame>(first)) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": opens as a stream but delivers no frame; check that it plays"));
  }
  EGOSIEVE_RETURN_IF_ERROR(stream->SeekTo(0));
  return std::unique_ptr<FrameSource>(std::move(stream));
}

}  // namespace egosieve::vision
