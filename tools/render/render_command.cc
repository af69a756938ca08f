#include "tools/render/render_command.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/interruption.h"
#include "tools/cli/object_flags.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/warning.h"
#include "tools/infer/shard.h"
#include "tools/render/overlay_video.h"
#include "tools/render/render_run.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

class RenderCommand : public Command {
 public:
  std::string name() const override { return "render"; }
  std::string summary() const override {
    return "Draws a run's movers, or its maps, over its frames, as images and as a video.";
  }
  std::string example() const override { return "egosieve render out/drive --object_high=0.9"; }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", directory_, "The run folder; its render/ and overlay.mp4 are written")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--input", input_, "Where the run's input is now, if it was moved")
        ->type_name("PATH");
    AddObjectFlags(app, overlay_.objects);
    app.add_flag("--movers,!--map", movers_,
                 "Show the movers that reconstruct has numbered, where it has; --map: the map");
    app.add_flag("--outlines", overlay_.outlines_only, "Of movers, draw nothing but outlines");
    app.add_flag("--legend,!--no_legend", overlay_.legend, "Draw the legend");
    app.add_flag("--images,!--no_images", images_, "Write render/NNNNNN.png");
    app.add_flag("--video,!--no_video", video_, "Write overlay.mp4");
    app.add_option("--rate", rate_hz_, "The video's frames per second; 0: the input's")
        ->check(Between(0.0, 240.0))
        ->type_name("HZ");
    range_.AddFlags(app);
    app.add_option("--shard", shard_,
                   "Draws the images of the K-th of N shares, from 1 on, and no video, which takes "
                   "all of them")
        ->type_name("K/N");
    device_.AddFlag(app);
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_ASSIGN_OR_RETURN(const Shard shard, ParseShard(shard_, kPieceFrames));
    if (shard.count > 1) video_ = false;
    if (!images_ && !video_) {
      return absl::InvalidArgumentError(
          "--no_images and --no_video, or --shard, leave nothing to do; leave one of them out");
    }
    EGOSIEVE_RETURN_IF_ERROR(overlay_.objects.Validate());
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(directory_));
    EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, ChooseLines(folder, range_));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
    EGOSIEVE_RETURN_IF_ERROR(CheckMaps(folder, description, lines));
    lines.erase(std::remove_if(lines.begin(), lines.end(),
                               [&](const FrameLine& line) { return !shard.Contains(line.index); }),
                lines.end());
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, device_.Open());
    EGOSIEVE_ASSIGN_OR_RETURN(OverlaySource overlays,
                              OverlaySource::Open(device.context, folder, input_));
    overlays.ShowMovers(movers_);
    RemoveAbandonedFiles(folder.path());
    Progress progress("render", progress_, static_cast<int64_t>(lines.size()));
    if (rate_hz_ == 0.0) rate_hz_ = FrameRate(lines);
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
    if (images_) {
      absl::StrAppendFormat(&text, "%d overlays in %s\n", frames_, folder.File("render"));
    }
    result_.Tell(name(), {{"run", folder.path()}, {"frames", frames_}, {"video", video}}, text);
    Warn(DescribeMissingMaps(folder, description, lines));
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
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat3b picture, overlays.Draw(line, overlay_));
    if (images_) {
      EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("render")));
      EGOSIEVE_RETURN_IF_ERROR(WritePng(folder.FrameFile("render", line.index, ".png"), picture));
    }
    if (video_) {
      EGOSIEVE_RETURN_IF_ERROR(AppendToVideo(folder, picture));
    }
    ++frames_;
    return absl::OkStatus();
  }

  // The first picture sets the video's size; frames of other sizes are left out of the video.
  absl::Status AppendToVideo(const RunFolder& folder, const cv::Mat3b& picture) {
    if (!writer_) {
      EGOSIEVE_ASSIGN_OR_RETURN(OverlayVideo writer, OverlayVideo::Open(folder.File("overlay"),
                                                                        picture.size(), rate_hz_));
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

  std::string directory_, input_, shard_;
  OverlayOptions overlay_;
  bool images_ = true, video_ = true, movers_ = true;
  double rate_hz_ = 0.0;
  FrameRange range_;
  DeviceFlag device_;
  ProgressFlag progress_;
  ResultFlag result_;

  std::optional<OverlayVideo> writer_;
  cv::Size video_size_;
  int64_t frames_ = 0, failed_ = 0, other_sizes_ = 0;
};

}  // namespace

std::unique_ptr<Command> MakeRenderCommand() { return std::make_unique<RenderCommand>(); }

}  // namespace egosieve::tools
