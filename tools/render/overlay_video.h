// A video from pictures of one size, in the best format that this machine's FFmpeg can write:
// H.264 in mp4 (every browser plays it), else MPEG-4 part 2 in mp4, else Motion JPEG in avi.
#ifndef EGOSIEVE_TOOLS_RENDER_OVERLAY_VIDEO_H_
#define EGOSIEVE_TOOLS_RENDER_OVERLAY_VIDEO_H_

#include <cstdint>
#include <opencv2/videoio.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::tools {

class OverlayVideo {
 public:
  // Writes beside `path_without_suffix` until Finish, which gives the file its name. `size` has
  // even sides; rate_hz > 0. Unavailable where no format can be written.
  static absl::StatusOr<OverlayVideo> Open(const std::string& path_without_suffix, cv::Size size,
                                           double rate_hz);

  // picture: CV_8UC3 of the size given to Open.
  void Append(const cv::Mat3b& picture) {
    writer_.write(picture);
    ++frames_;
  }

  // Completes the file and returns its path. ResourceExhausted where the disk has not all of it.
  absl::StatusOr<std::string> Finish();

  // Empty for H.264; else a sentence on what was written instead, and what to install.
  const std::string& warning() const { return warning_; }

 private:
  OverlayVideo() = default;

  cv::VideoWriter writer_;
  int64_t frames_ = 0;
  std::string temporary_path_;
  std::string path_;
  std::string warning_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RENDER_OVERLAY_VIDEO_H_
