// A video of pictures of one size, in the best format that the installed FFmpeg can write: H.264 in
// mp4 (every browser plays it), else MPEG-4 part 2 in mp4, else Motion JPEG in avi.
#ifndef EGOSIEVE_TOOLS_RENDER_OVERLAY_VIDEO_H_
#define EGOSIEVE_TOOLS_RENDER_OVERLAY_VIDEO_H_

#include <cstdint>
#include <opencv2/videoio.hpp>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "kernels/files/atomic_file.h"

namespace egosieve::tools {

class OverlayVideo {
 public:
  // Writes to a temporary file beside `path_without_suffix`; Finish gives it its name. `size` has
  // even sides; rate_hz > 0. Unavailable if no format can be written.
  static absl::StatusOr<OverlayVideo> Open(const std::string& path_without_suffix, cv::Size size,
                                           double rate_hz);

  // picture: CV_8UC3 of the size given to Open.
  void Append(const cv::Mat3b& picture) {
    writer_.write(picture);
    ++frames_;
  }

  // Completes the file and returns its path. ResourceExhausted if the disk could not hold all of
  // it.
  absl::StatusOr<std::string> Finish();

  // Empty for H.264; else a sentence with the format written instead and the package to install.
  const std::string& warning() const { return warning_; }

 private:
  OverlayVideo() = default;

  cv::VideoWriter writer_;
  std::optional<kernels::TemporaryFile> file_;
  int64_t frames_ = 0;
  std::string path_;
  std::string warning_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RENDER_OVERLAY_VIDEO_H_
