#include "tools/render/render_run.h"

#include <CLI/CLI.hpp>
#include <algorithm>
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
#include "tools/cli/checks.h"
#include "tools/cli/command.h"
#include "tools/cli/interruption.h"
#include "tools/cli/object_flags.h"
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
    EGOSIEVE_ASSIGN_OR_RETURN(OverlaySource overlays, OverlaySource::Open(folder, options_.input));
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
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string video, FinishVideo(folder.File("overlay.mp4")));
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
      EGOSIEVE_RETURN_IF_ERROR(AppendToVideo(folder.File("overlay.mp4"), picture));
    }
    ++frames_;
    return absl::OkStatus();
  }

  // The first picture, whose sides are even, sets the video's size; frames of other sizes are left
  // out of the video.
  absl::Status AppendToVideo(const std::string& path, const cv::Mat3b& picture) {
    if (!file_) EGOSIEVE_RETURN_IF_ERROR(OpenVideo(path, picture.size()));
    if (picture.size() == video_size_) {
      writer_.write(picture);
      ++video_frames_;
    } else {
      ++other_sizes_;
    }
    return absl::OkStatus();
  }

  // H.264, which every browser plays, or, where the installed FFmpeg cannot write it, MPEG-4 part 2.
  absl::Status OpenVideo(const std::string& path, cv::Size size) {
    video_size_ = size;
    for (const std::string code : {"avc1", "mp4v"}) {
      EGOSIEVE_ASSIGN_OR_RETURN(file_, kernels::TemporaryFile::Create(path, ".mp4"));
      const int fourcc = cv::VideoWriter::fourcc(code[0], code[1], code[2], code[3]);
      // Tried twice: a file that failed to open once does not mean a missing encoder.
      for (int attempt = 0; attempt < 2; ++attempt) {
        if (writer_.open(file_->name(), cv::CAP_FFMPEG, fourcc, options_.rate_hz, size)) {
          return absl::OkStatus();
        }
      }
      warning_ =
          "this FFmpeg writes no H.264 (libx264 is missing): the video is MPEG-4 part 2, which "
          "browsers do not play";
    }
    file_.reset();
    return absl::UnavailableError(
        absl::StrCat("cannot write a video to ", path,
                     "; check that the folder can be written, or use --no_video"));
  }

  // The video's path; empty if there is none. ResourceExhausted if the disk could not hold it.
  absl::StatusOr<std::string> FinishVideo(const std::string& path) {
    if (!file_) return std::string();
    writer_.release();
    EGOSIEVE_RETURN_IF_ERROR(vision::CheckWrittenVideo(file_->name(), video_frames_));
    EGOSIEVE_RETURN_IF_ERROR(file_->Commit());
    Warn(warning_);
    if (other_sizes_ > 0) {
      Warn(absl::StrCat(other_sizes_, " frames of another size are not in the video"));
    }
    return path;
  }

  RenderOptions options_;
  cv::VideoWriter writer_;
  std::optional<kernels::TemporaryFile> file_;  // of the video
  cv::Size video_size_;
  std::string warning_;
  int64_t video_frames_ = 0;
  int64_t frames_ = 0, failed_ = 0, other_sizes_ = 0;
};

class RenderCommand : public Command {
 public:
  std::string name() const override { return "render"; }
  std::string summary() const override {
    return "Draws a run's movers, or its maps, over its frames, as a video and as images.";
  }
  std::string example() const override { return "egosieve render out/drive --object_high=0.9"; }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", options_.directory,
                   "The run folder; its overlay.mp4, and with --images its render/, are written")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--input", options_.input, "Where the run's input is now, if it was moved")
        ->type_name("PATH");
    AddObjectFlags(app, options_.overlay.objects);
    AddSwitch(app, "--movers", "--map", options_.movers,
              "Show the movers that refine has numbered, where it has; --map: the map");
    app.add_flag("--outlines", options_.overlay.outlines_only,
                 "Of movers, draw nothing but outlines");
    AddSwitch(app, "--legend", "--no_legend", options_.overlay.legend, "Draw the legend");
    app.add_flag("--images", options_.images, "Write each frame's overlay, too: render/NNNNNN.png");
    AddSwitch(app, "--video", "--no_video", options_.video, "Write overlay.mp4");
    app.add_option("--rate", options_.rate_hz, "The video's frames per second; 0: the input's")
        ->check(Between(0.0, 240.0))
        ->type_name("HZ");
    options_.range.AddFlags(app);
    options_.progress.AddFlag(app);
    options_.result.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override { return RunRender(options_); }

 private:
  RenderOptions options_;
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

std::unique_ptr<Command> MakeRenderCommand() { return std::make_unique<RenderCommand>(); }

}  // namespace egosieve::tools
