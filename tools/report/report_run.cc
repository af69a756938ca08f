#include "tools/report/report_run.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/command.h"
#include "tools/cli/interruption.h"
#include "tools/cli/object_flags.h"
#include "tools/cli/warning.h"
#include "tools/render/overlay_source.h"
#include "tools/report/page.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/run_folder/doubtful_frames.h"
#include "tools/run_folder/former_run.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {
namespace {

constexpr int kPictureWidth = 960;

std::string Jpeg(const cv::Mat3b& picture) {
  cv::Mat small = picture;
  if (picture.cols > kPictureWidth) {
    const double scale = static_cast<double>(kPictureWidth) / picture.cols;
    cv::resize(picture, small, cv::Size(), scale, scale, cv::INTER_AREA);
  }
  std::vector<uchar> bytes;
  cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, 82});
  return std::string(bytes.begin(), bytes.end());
}

// `count` lines spread evenly over those with a map, including the first and the last.
std::vector<FrameLine> ChoosePictures(const std::vector<FrameLine>& lines, int64_t count) {
  std::vector<FrameLine> with_map;
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(with_map), [](const FrameLine& line) {
    return line.outcome != FrameLine::Outcome::kFailed && line.model_size > 0 && line.has_map();
  });
  const int64_t size = static_cast<int64_t>(with_map.size());
  if (size <= count) return with_map;
  std::vector<FrameLine> chosen;
  for (int64_t i = 0; i < count; ++i) {
    chosen.push_back(with_map[count == 1 ? size / 2 : i * (size - 1) / (count - 1)]);
  }
  return chosen;
}

// Empty if the run has no such file.
absl::StatusOr<std::string> ReadIfThere(const RunFolder& folder, const char* name) {
  absl::StatusOr<std::string> text = ReadFile(folder.File(name));
  if (absl::IsNotFound(text.status())) return std::string();
  return text;
}

// If the input is missing, the page lacks its pictures but not its charts.
absl::Status AddPictures(const ReportOptions& options, const RunFolder& folder,
                         ReportContent& content) {
  const auto tell = [&content](absl::string_view what) {
    Warn(what);
    content.picture_notes.emplace_back(what);
  };
  if (const std::string missing = DescribeMissingMaps(folder, content.lines); !missing.empty()) {
    tell(missing);
  }
  const std::vector<FrameLine> lines = ChoosePictures(content.lines, options.pictures);
  if (lines.empty()) return absl::OkStatus();
  absl::StatusOr<OverlaySource> overlays = OverlaySource::Open(folder, options.input);
  if (!overlays.ok()) {
    tell(absl::StrCat("no pictures: ", overlays.status().message()));
    return absl::OkStatus();
  }
  content.picture_notes.push_back(absl::StrFormat(
      "Where refine has numbered them, each mover has a colour and its number. Else orange: "
      "likely to move by itself; blue: likely part of the static scene; no colour: unsure; lines "
      "around connected pixels with a probability of %.2f and more, somewhere of %.2f and more.",
      options.overlay.objects.low, options.overlay.objects.high));
  Progress progress("report", options.progress, static_cast<int64_t>(lines.size()), "picture");
  OverlayOptions overlay = options.overlay;
  overlay.legend = false;
  for (const FrameLine& line : lines) {
    if (InterruptionRequested()) {
      return absl::CancelledError("interrupted; nothing was written");
    }
    const absl::StatusOr<cv::Mat3b> picture = overlays->Draw(line, overlay);
    if (!picture.ok()) {
      tell(absl::StrCat("pictures are missing: ", picture.status().message()));
      return absl::OkStatus();
    }
    const std::string doubt = DoubtOf(line);
    content.pictures.push_back(
        {Jpeg(*picture),
         absl::StrFormat("frame %d, %.2f s: %.1f %% moves%s", line.index, line.time_seconds,
                         100.0 * line.dynamic_share,
                         doubt.empty() ? "" : absl::StrCat("; unreliable: ", doubt)),
         !doubt.empty()});
    progress.Advance();
  }
  return absl::OkStatus();
}

class ReportCommand : public Command {
 public:
  std::string name() const override { return "report"; }
  std::string summary() const override {
    return "Makes one self-contained HTML page of a run: overlays, charts, frames that were not "
           "learnt from.";
  }
  std::string example() const override { return "egosieve report out/drive"; }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", options_.directory, "The run folder; its report.html is written")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--input", options_.input, "Where the run's input is now, if it was moved")
        ->type_name("PATH");
    app.add_option("--pictures", options_.pictures, "Overlays on the page, evenly over the drive")
        ->check(Between(0, 1000))
        ->type_name("NUMBER");
    AddObjectFlags(app, options_.overlay.objects);
    options_.progress.AddFlag(app);
    options_.result.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override { return RunReport(options_); }

 private:
  ReportOptions options_;
};

}  // namespace

absl::StatusOr<ExitCode> RunReport(const ReportOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.overlay.objects.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(options.directory));
  ReportContent content;
  EGOSIEVE_ASSIGN_OR_RETURN(content.description, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(content.lines, folder.ReadLines());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string evaluation, ReadIfThere(folder, "eval.json"));
  if (!evaluation.empty()) {
    try {
      const auto parsed = nlohmann::ordered_json::parse(evaluation);
      EvaluationSection(parsed);
      content.evaluation = parsed;
    } catch (const nlohmann::json::exception& error) {
      Warn(absl::StrCat("the report has no evaluation: ", folder.File("eval.json"),
                        " cannot be used: ", error.what(), "; run egosieve-eval again"));
    }
  }
  EGOSIEVE_ASSIGN_OR_RETURN(content.tracks, ReadIfThere(folder, "tracks.csv"));
  if (std::filesystem::exists(folder.File("overlay.mp4"))) content.video = "overlay.mp4";
  EGOSIEVE_RETURN_IF_ERROR(AddPictures(options, folder, content));
  RemoveAbandonedFiles(folder.path());
  const std::string path = folder.File("report.html");
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(path, MakeReportPage(content)));
  options.result.Tell("report", {{"report", path}}, absl::StrCat("report in ", path, "\n"));
  return ExitCode::kDone;
}

std::unique_ptr<Command> MakeReportCommand() { return std::make_unique<ReportCommand>(); }

}  // namespace egosieve::tools
