// egosieve masks INPUT|RUN: masks as other programs read them (mask_format.h).
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/command.h"
#include "tools/cli/command_line.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/version.h"
#include "tools/cli/warning.h"
#include "tools/masks/mask_export.h"
#include "tools/masks/masks_flags.h"
#include "tools/refine/refine_run.h"
#include "tools/run_folder/chosen_lines.h"

namespace egosieve::tools {
namespace {

// How to use the masks in `out` for pictures in `images`; empty if that needs no explanation.
std::string HowToUse(const MaskExportOptions& options, const std::string& images) {
  const std::string& out = options.out;
  switch (options.format) {
    case MaskFormat::kColmap:
      if (!options.undistort.empty()) {
        return absl::StrCat("colmap stereo_fusion --workspace_path=", options.undistort,
                            " --output_path=", options.undistort,
                            "/fused.ply --StereoFusion.mask_path=", out, "\n");
      }
      return absl::StrCat("colmap feature_extractor --database_path=DATABASE --image_path=", images,
                          " --ImageReader.mask_path=", out, " --ImageReader.single_camera=1\n");
    case MaskFormat::kNerfstudio:
      return absl::StrCat("ns-train nerfacto --data=", out, "\n");
    case MaskFormat::kInstantNgp:
      return "instant-ngp finds them next to the pictures that transforms.json names\n";
    case MaskFormat::kGaussianSplatting:
      return absl::StrCat("train.py --source_path=SCENE --images=", AbsolutePath(out), "\n");
    case MaskFormat::kMetashape:
      return absl::StrCat(
          "Metashape: Import Masks, From File, template {filename}_mask.png, folder ", out, "\n");
    case MaskFormat::kRealityScan:
      return "RealityScan finds them next to the pictures\n";
    default:
      return "";
  }
}

// The run of `masks`: segments the input and refines its masks where these are missing, then
// writes them for the other program. Errors of usage, of the input and of the environment; where
// segment or refine fails, its exit code. Nothing is written before all checks that need no
// segmented input.
class MasksRun {
 public:
  explicit MasksRun(MasksFlags& flags) : flags_(flags) {}

  absl::StatusOr<ExitCode> Run() {
    EGOSIEVE_RETURN_IF_ERROR(flags_.Resolve());
    const bool is_run = RunFolder::Open(flags_.input).ok();
    if (!is_run && !flags_.moved.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat(flags_.input, " is no run folder; --input takes one"));
    }
    std::string pictures = flags_.input;
    if (is_run) {
      EGOSIEVE_RETURN_IF_ERROR(flags_.CheckForRun());
      flags_.run = flags_.input;
      EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(flags_.run));
      EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
      pictures = flags_.moved.empty() ? description.input.path : flags_.moved;
    } else if (flags_.run.empty()) {
      flags_.run = absl::StrCat(AbsolutePath(flags_.options.out), ".run");
    }
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenDriveInput(pictures, 0));
    EGOSIEVE_ASSIGN_OR_RETURN(MaskExport output,
                              MaskExport::Prepare(std::move(input), flags_.run, flags_.options));
    const std::string images = pictures;
    if (!flags_.options.video.empty()) {
      EGOSIEVE_RETURN_IF_ERROR(FindPictures(output));
      pictures = flags_.options.video;
    }
    ExitCode code = ExitCode::kDone;
    if (!is_run) {
      code = Step({"segment", pictures, absl::StrCat("--out=", flags_.run), "--resume"}, true);
      if (code != ExitCode::kDone && code != ExitCode::kFramesFailed) return code;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(flags_.run));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> all, ChooseLines(folder, FrameRange()));
    EGOSIEVE_RETURN_IF_ERROR(CheckMaps(folder, all));
    const std::vector<FrameLine> lines = LinesWithMaps(all);
    if (lines.size() < all.size()) code = ExitCode::kFramesFailed;
    if (!HasMasks(folder, lines)) {
      std::vector<std::string> words = {"refine", flags_.run, absl::StrCat("--input=", pictures)};
      // Products that refine already made with its own thresholds stay.
      if (flags_.options.mask.threshold) words.push_back("--what=probability");
      if (!IsRefined(folder)) words.push_back("--resume");
      const ExitCode made = Step(std::move(words), false);
      if (made != ExitCode::kDone && made != ExitCode::kFramesFailed) return made;
    }
    Progress progress("masks", flags_.progress, static_cast<int64_t>(lines.size()));
    EGOSIEVE_RETURN_IF_ERROR(
        output.Run(folder, lines, [&] { return progress.AdvanceUninterrupted(); }));
    progress.Finish();
    Tell(output, images);
    return code;
  }

 private:
  absl::Status FindPictures(MaskExport& output) const {
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput video, OpenDriveInput(flags_.options.video, 0));
    Progress progress("find pictures", flags_.progress, video.frames->expected_frame_count());
    return output.FindPictures(*video.frames, [&] { return progress.AdvanceUninterrupted(); });
  }

  // Runs another command of the program, which reports its own errors.
  ExitCode Step(std::vector<std::string> words, bool segments) const {
    const auto pass = [&](const auto& flags) {
      for (const auto& [flag, value] : flags) {
        if (value) words.push_back(absl::StrCat(flag, "=", *value));
      }
    };
    if (segments) pass(flags_.passed);
    pass(flags_.passed_to_both);
    if (flags_.progress.mode != ProgressMode::kAuto) {
      words.push_back(flags_.progress.mode == ProgressMode::kJson ? "--progress=json"
                                                                  : "--progress=none");
    }
    if (flags_.result.json) words.push_back("--json");
    CommandLine line("egosieve", "", kVersion);
    line.Add(MakeSegmentCommand());
    line.Add(MakeRefineCommand());
    return static_cast<ExitCode>(line.Run(std::move(words), std::cout, std::cerr));
  }

  // The lines of frames that could be read and have a map.
  static std::vector<FrameLine> LinesWithMaps(std::vector<FrameLine> lines) {
    lines.erase(std::remove_if(lines.begin(), lines.end(),
                               [](const FrameLine& line) {
                                 return !line.has_map() ||
                                        line.outcome == FrameLine::Outcome::kFailed;
                               }),
                lines.end());
    return lines;
  }

  bool HasMasks(const RunFolder& folder, const std::vector<FrameLine>& lines) const {
    return IsRefined(folder) && std::all_of(lines.begin(), lines.end(), [&](const FrameLine& line) {
             return std::filesystem::exists(MaskSource(folder, line.index, flags_.options.mask));
           });
  }

  // `input`: as given, or as stored in the run.
  void Tell(const MaskExport& output, const std::string& input) const {
    std::string text = absl::StrCat(output.images(), " masks in ", flags_.options.out,
                                    "; the run is kept in ", flags_.run, "\n");
    if (output.is_video() && flags_.options.frames.empty() && IsForScenes(flags_.options.format)) {
      absl::StrAppend(&text,
                      "they go by the names 000000.png and so on; --frames=DIR writes the video's "
                      "pictures by these\n");
    }
    std::error_code error;
    const std::string images = !flags_.options.frames.empty()                ? flags_.options.frames
                               : std::filesystem::is_directory(input, error) ? input
                                                                             : "IMAGES";
    absl::StrAppend(&text, HowToUse(flags_.options, images));
    nlohmann::ordered_json fields = {
        {"folder", flags_.options.out}, {"run", flags_.run}, {"images", output.images()}};
    flags_.result.Tell("masks", fields, text);
    for (const std::string& warning : output.warnings()) Warn(warning);
  }

  MasksFlags& flags_;
};

class MasksCommand : public Command {
 public:
  std::string name() const override { return "masks"; }
  std::string summary() const override {
    return "Writes masks of what moves as COLMAP, nerfstudio and others read them.";
  }
  std::string example() const override {
    return "egosieve masks images --for=colmap --dilate=10 --out=out/masks\n"
           "egosieve masks data/images --for=nerfstudio --dilate=10 --out=out/data\n"
           "egosieve masks my.mp4 --for=colmap --out=out/masks --frames=out/images\n"
           "egosieve masks images --from_video=my.mp4 --for=colmap --out=out/masks\n"
           "egosieve masks out/masks.run --for=coco --out=out/coco";
  }
  void AddFlags(CLI::App& app) override { flags_.AddFlags(app); }
  absl::StatusOr<ExitCode> Run() override { return MasksRun(flags_).Run(); }

 private:
  MasksFlags flags_;
};

}  // namespace

std::unique_ptr<Command> MakeMasksCommand() { return std::make_unique<MasksCommand>(); }

}  // namespace egosieve::tools
