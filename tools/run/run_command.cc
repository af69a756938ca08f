// egosieve run VIDEO: segment, refine, render and report into one folder.
#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/command.h"
#include "tools/cli/output_folder.h"
#include "tools/refine/refine_run.h"
#include "tools/render/overlay_source.h"
#include "tools/render/render_run.h"
#include "tools/report/report_run.h"
#include "tools/run/closing_lines.h"
#include "tools/run_folder/map_image.h"
#include "tools/run_folder/run_folder.h"
#include "tools/segment/segment_run.h"
#include "vision/frame/video_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

constexpr char kPreview[] = "preview.png";
constexpr std::chrono::seconds kPreviewInterval{10};

// Whether the file is there and as new as refine's products.
bool IsNew(const RunFolder& folder, const char* name) {
  std::error_code error, none;
  const fs::file_time_type made = fs::last_write_time(folder.File(kRefineState), error);
  const fs::file_time_type time = fs::last_write_time(folder.File(name), none);
  return !error && !none && time >= made;
}

class RunCommand : public Command {
 public:
  std::string name() const override { return "run"; }
  std::string summary() const override {
    return "Does it all for one video: masks of what moves, numbered movers, an overlay video and "
           "a report. The same call again goes on where it stopped.";
  }
  std::string example() const override {
    return "egosieve run my.mp4\n"
           "egosieve run my.mp4 -o out/beginning --max-frames=100";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("INPUT", segment_.input,
                   "A video, a folder or a glob of images or of a drive's videos, or a list of "
                   "images with their times, .txt or .csv")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("-o,--out", segment_.directory,
                   "The folder for everything; default: out/NAME of INPUT")
        ->type_name("DIR");
    segment_.given.AddFlags(app, {"camera", "from", "ignore", "max_frames", "skip", "to"});
    AddSwitch(app, "--video", "--no_video", has_video_, "Draw overlay.mp4");
    segment_.threads.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    if (vision::IsStreamAddress(segment_.input)) {
      return absl::InvalidArgumentError(
          "a stream has no end; egosieve segment takes it, and refine, render and report what it "
          "recorded");
    }
    if (RunFolder::Open(segment_.input).ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat(segment_.input, " is a run folder; give the video or the pictures, and -o ",
                       segment_.input));
    }
    const absl::StatusOr<ExitCode> code = RunAll();
    if (!absl::IsCancelled(code.status())) return code;
    return absl::CancelledError(
        absl::StrCat("interrupted; the same command goes on in ", segment_.directory));
  }

 private:
  absl::StatusOr<ExitCode> RunAll() {
    segment_.resume = segment_.result.quiet = true;
    segment_.watch = [this](const FrameLine& line) { return Preview(line); };
    if (segment_.directory.empty()) segment_.directory = DefaultFolder(segment_.input);
    const std::string finished = FinishedUtc(segment_.directory);
    EGOSIEVE_ASSIGN_OR_RETURN(const ExitCode code, RunSegment(segment_));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(segment_.directory));
    bool has_news = finished.empty() || finished != FinishedUtc(segment_.directory);
    EGOSIEVE_RETURN_IF_ERROR(Refine(folder, has_news));
    if (has_video_ && !IsNew(folder, "overlay.mp4")) {
      RenderOptions render;
      render.directory = segment_.directory;
      render.result.quiet = has_news = true;
      EGOSIEVE_RETURN_IF_ERROR(RunRender(render).status());
    }
    if (has_news || !IsNew(folder, "report.html")) {
      ReportOptions report;
      report.directory = segment_.directory;
      report.result.quiet = has_news = true;
      EGOSIEVE_RETURN_IF_ERROR(RunReport(report).status());
    }
    std::error_code error;
    fs::remove(folder.File(kPreview), error);
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string closing, ClosingLines(folder));
    if (!has_news) std::cout << segment_.directory << " was finished before; nothing was done\n";
    std::cout << closing;
    return code;
  }

  // Draws the map of the first frame that was learnt from, and of a later one every ten seconds.
  absl::StatusOr<std::string> Preview(const FrameLine& line) {
    const auto now = std::chrono::steady_clock::now();
    const bool is_first = !overlays_;
    if (line.outcome != FrameLine::Outcome::kLearnt) return "";
    if (!is_first && now - last_preview_ < kPreviewInterval) return "";
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(segment_.directory));
    if (is_first) {
      EGOSIEVE_ASSIGN_OR_RETURN(overlays_, OverlaySource::Open(folder, ""));
      overlays_->ShowMovers(false);
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat3b picture, overlays_->Draw(line, {}));
    const std::string path = folder.File(kPreview);
    EGOSIEVE_RETURN_IF_ERROR(WritePng(path, picture));
    last_preview_ = now;
    return is_first ? absl::StrCat(path, " shows the newest frame, for as long as this goes on")
                    : "";
  }

  absl::Status Refine(const RunFolder& folder, bool& has_news) const {
    RefineFlags refine;
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
    EGOSIEVE_ASSIGN_OR_RETURN(const bool is_same, IsResumable(folder, lines, refine.options));
    if (is_same && IsRefined(folder)) return absl::OkStatus();
    refine.options.resume = true;
    refine.directory = segment_.directory;
    refine.result.quiet = has_news = true;
    return RunRefine(refine).status();
  }

  SegmentCall segment_;
  std::optional<OverlaySource> overlays_;  // of the previews; absent before the first
  std::chrono::steady_clock::time_point last_preview_;
  bool has_video_ = true;
};

}  // namespace

std::unique_ptr<Command> MakeRunCommand() { return std::make_unique<RunCommand>(); }

}  // namespace egosieve::tools
