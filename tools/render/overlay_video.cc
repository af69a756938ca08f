#include "tools/render/overlay_video.h"

#include <array>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/written_video.h"

namespace egosieve::tools {
namespace {

struct Format {
  const char* fourcc;
  const char* suffix;
  const char* warning;
};

constexpr std::array<Format, 3> kFormats = {
    {{"avc1", ".mp4", ""},
     {"mp4v", ".mp4",
      "this FFmpeg writes no H.264 (libx264 is missing): the video is MPEG-4 part 2, which "
      "browsers "
      "do not play"},
     {"MJPG", ".avi",
      "this FFmpeg writes neither H.264 nor MPEG-4 (libx264 is missing): the video is Motion JPEG "
      "in an .avi, which is large and which browsers do not play"}}};

}  // namespace

absl::StatusOr<OverlayVideo> OverlayVideo::Open(const std::string& path_without_suffix,
                                                cv::Size size, double rate_hz) {
  OverlayVideo video;
  for (const Format& format : kFormats) {
    video.path_ = absl::StrCat(path_without_suffix, format.suffix);
    EGOSIEVE_ASSIGN_OR_RETURN(video.file_,
                              kernels::TemporaryFile::Create(video.path_, format.suffix));
    video.warning_ = format.warning;
    const char* code = format.fourcc;
    const int fourcc = cv::VideoWriter::fourcc(code[0], code[1], code[2], code[3]);
    const auto opens = [&] {
      return video.writer_.open(video.file_->name(), cv::CAP_FFMPEG, fourcc, rate_hz, size);
    };
    // Tried twice: a file that failed to open once does not mean a missing encoder.
    if (opens() || opens()) return video;
  }
  return absl::UnavailableError(
      absl::StrCat("cannot write a video to ", path_without_suffix,
                   ".mp4; check that the folder can be written, or use --no_video"));
}

absl::StatusOr<std::string> OverlayVideo::Finish() {
  writer_.release();
  EGOSIEVE_RETURN_IF_ERROR(vision::CheckWrittenVideo(file_->name(), frames_));
  EGOSIEVE_RETURN_IF_ERROR(file_->Commit());
  return path_;
}

}  // namespace egosieve::tools
