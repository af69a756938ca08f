#include "tools/render/render_run.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"
#include "tools/cli/interruption.h"
#include "tools/cli/warning.h"
#include "tools/render/overlay_source.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/map_image.h"
#include "tools/run_folder/run_folder.h"
#include "vision/frame/video_file.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::tools {
namespace {

// A video of pictures of one size, in the best format that the installed FFmpeg can write: H.264 in
// mp4 (every browser plays it), else MPEG-4 part 2 in mp4, else Motion JPEG in avi.
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

class RenderRun {
 public:
  explicit RenderRun(const RenderOptions& options) : options_(options) {}

  absl::StatusOr<ExitCode> Run() {
    if (!options_.images && !options_.video) {
      return absl::InvalidArgumentError(
          "--no_video without --images leaves nothing to do; leave it out, or add --images");
    }
    EGOSIEVE_RETURN_IF_ERROR(options_.overlay.objects.Validate());
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(options_.directory));
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines,
                              ChooseLines(folder, options_.range));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
    EGOSIEVE_RETURN_IF_ERROR(CheckMaps(folder, lines));
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, options_.device.Open());
    EGOSIEVE_ASSIGN_OR_RETURN(OverlaySource overlays,
                              OverlaySource::Open(device.context, folder, options_.input));
    overlays.ShowMovers(options_.movers);
    RemoveAbandonedFiles(folder.path());
    Progress progress("render", options_.progress, static_cast<int64_t>(lines.size()));
    if (options_.rate_hz == 0.0) options_.rate_hz = FrameRate(lines);
    absl::Status status = absl::OkStatus();
    for (const FrameLine& line : lines) {
      status = RenderFrame(folder, line, overlays);
      if (!status.ok()) break;
      progress.Advance();
    }
    progress.Finish();
    // Frames drawn before an error or an interruption also make a complete video.
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string video, FinishVideo());
    EGOSIEVE_RETURN_IF_ERROR(status);
    std::string text = video.empty() ? "" : absl::StrCat("video in ", video, "\n");
    if (options_.images) {
      absl::StrAppendFormat(&text, "%d overlays in %s\n", frames_, folder.File("render"));
    }
    options_.result.Tell("render", {{"run", folder.path()}, {"frames", frames_}, {"video", video}},
                         text);
    Warn(DescribeMissingMaps(folder, lines));
    return failed_ > 0 ? ExitCode::kFramesFailed : ExitCode::kDone;
  }

 private:
  absl::Status RenderFrame(const RunFolder& folder, const FrameLine& line,
                           OverlaySource& overlays) {
    if (InterruptionRequested()) {
      return absl::CancelledError(absl::StrCat("interrupted after ", frames_, " frames"));
    }
    if (line.outcome == FrameLine::Outcome::kFailed) {
      ++failed_;
      return absl::OkStatus();
    }
    if (!line.has_map()) return absl::OkStatus();
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat3b picture, overlays.Draw(line, options_.overlay));
    if (options_.images) {
      EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("render")));
      EGOSIEVE_RETURN_IF_ERROR(WritePng(folder.FrameFile("render", line.index, ".png"), picture));
    }
    if (options_.video) {
      EGOSIEVE_RETURN_IF_ERROR(AppendToVideo(folder, picture));
    }
    ++frames_;
    return absl::OkStatus();
  }

  // The first picture sets the video's size; frames of other sizes are left out of the video.
  absl::Status AppendToVideo(const RunFolder& folder, const cv::Mat3b& picture) {
    if (!writer_) {
      EGOSIEVE_ASSIGN_OR_RETURN(
          OverlayVideo writer,
          OverlayVideo::Open(folder.File("overlay"), picture.size(), options_.rate_hz));
      writer_ = std::move(writer);
      video_size_ = picture.size();
    }
    if (picture.size() == video_size_) {
      writer_->Append(picture);
    } else {
      ++other_sizes_;
    }
    return absl::OkStatus();
  }

  // The video's path; empty if there is none.
  absl::StatusOr<std::string> FinishVideo() {
    if (!writer_) return std::string();
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string path, writer_->Finish());
    Warn(writer_->warning());
    if (other_sizes_ > 0) {
      Warn(absl::StrCat(other_sizes_, " frames of another size are not in the video"));
    }
    return path;
  }

  RenderOptions options_;
  std::optional<OverlayVideo> writer_;
  cv::Size video_size_;
  int64_t frames_ = 0, failed_ = 0, other_sizes_ = 0;
};

}  // namespace

double FrameRate(const std::vector<FrameLine>& lines) {
  std::vector<double> gaps;
  for (size_t i = 1; i < lines.size(); ++i) {
    const double gap = (lines[i].time_seconds - lines[i - 1].time_seconds) /
                       static_cast<double>(lines[i].index - lines[i - 1].index);
    if (gap > 0.0) gaps.push_back(gap);
  }
  if (gaps.empty()) return 10.0;
  return std::clamp(1.0 / vision::MedianInPlace(gaps), 1.0, 60.0);
}

absl::StatusOr<ExitCode> RunRender(const RenderOptions& options) {
  return RenderRun(options).Run();
}

}  // namespace egosieve::tools
