#include "tools/masks/masks_command.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/command_line.h"
#include "tools/cli/interruption.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/version.h"
#include "tools/cli/warning.h"
#include "tools/masks/mask_export.h"
#include "tools/reconstruct/full_maps.h"
#include "tools/reconstruct/reconstruct_command.h"
#include "tools/reconstruct/reconstruct_run.h"
#include "tools/run_folder/chosen_lines.h"
#include "tools/segment/segment_command.h"

namespace egosieve::tools {
namespace {

enum class Treatment { kDefault, kKeep, kMask };

// How to use the masks in `out` for pictures in `images`; empty if that needs no explanation.
std::string HowToUse(MaskFormat format, const std::string& images, const std::string& out) {
  switch (format) {
    case MaskFormat::kColmap:
      return absl::StrCat("colmap feature_extractor --database_path=DATABASE --image_path=", images,
                          " --ImageReader.mask_path=", out, " --ImageReader.single_camera=1\n");
    case MaskFormat::kNerfstudio:
      return absl::StrCat("ns-train nerfacto --data=", out, "\n");
    case MaskFormat::kInstantNgp:
      return "instant-ngp finds them next to the pictures that transforms.json names\n";
    case MaskFormat::kGaussianSplatting:
      return absl::StrCat("train.py --source_path=SCENE --images=", AbsolutePath(out), "\n");
    default:
      return "";
  }
}

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

  void AddFlags(CLI::App& app) override {
    app.add_option("INPUT", input_,
                   "A video, a folder of images or a glob, which are segmented first; or a run "
                   "folder")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--out", options_.out, "The folder to write the masks to")
        ->required()
        ->type_name("DIR");
    AddWords(app, "--for", options_.format, MaskFormatWords(), "The program that reads the masks");
    app.add_option("--dilate", options_.mask.dilate_pixels,
                   "Also mask pixels nearer than this to a mover; default: 0")
        ->type_name("PIXELS");
    app.add_option("--shadow_margin", options_.mask.shadow_margin_pixels,
                   "Also mask the shadows that movers cast, up to this distance from them: what is "
                   "darker than the ground around it and begins at their feet; default: 0, none")
        ->type_name("PIXELS");
    app.add_option("--threshold", options_.mask.threshold,
                   "Masks where the probability of moving is at least this; default: the masks of "
                   "reconstruct, by its own thresholds")
        ->type_name("P");
    AddWords(app, "--unsure", unsure_, TreatmentWords(),
             absl::StrCat(
                 "Pixels that are neither clearly moving nor clearly static; mask: as --threshold=",
                 ClassThresholds().static_below, "; default: keep"));
    AddWords(app, "--own_vehicle", own_vehicle_, TreatmentWords(),
             "The camera's own vehicle, where it was found, and what --ignore names; default: mask "
             "it for programs that build a scene, keep it for others");
    app.add_option("--also", options_.also,
                   "Own masks to unite with these, not 0 where masked: a folder with IMAGE.png or "
                   "NAME.png, or one picture for all images")
        ->type_name("PATH");
    app.add_flag("--invert", options_.invert,
                 "Exchange what is masked and what is not; not for davis, coco and mots");
    AddFileFlags(app);
    AddRunFlags(app);
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EGOSIEVE_RETURN_IF_ERROR(ResolveFlags());
    const bool is_run = RunFolder::Open(input_).ok();
    if (options_.shard.count > 1 && !is_run) {
      return absl::InvalidArgumentError(
          absl::StrCat(input_, " is no run folder; --shard takes one that has its masks"));
    }
    std::string pictures = input_;
    if (is_run) {
      EGOSIEVE_RETURN_IF_ERROR(CheckFlagsForRun());
      run_ = input_;
      EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(run_));
      EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
      pictures = moved_.empty() ? description.input.path : moved_;
    } else if (run_.empty()) {
      run_ = absl::StrCat(AbsolutePath(options_.out), ".run");
    }
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput input, OpenDriveInput(pictures, 0));
    EGOSIEVE_ASSIGN_OR_RETURN(MaskExport output,
                              MaskExport::Prepare(std::move(input), run_, options_));
    const std::string images = pictures;
    if (!options_.video.empty()) {
      EGOSIEVE_RETURN_IF_ERROR(FindPictures(output));
      pictures = options_.video;
    }
    ExitCode code = ExitCode::kDone;
    if (!is_run) {
      code = Step({"segment", pictures, absl::StrCat("--out=", run_), "--resume"}, true);
      if (code != ExitCode::kDone && code != ExitCode::kFramesFailed) return code;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(run_));
    EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> all, ChooseLines(folder, FrameRange()));
    EGOSIEVE_RETURN_IF_ERROR(CheckMaps(folder, description, all));
    const std::vector<FrameLine> lines = LinesWithMaps(all);
    if (lines.size() < all.size()) code = ExitCode::kFramesFailed;
    if (!HasMasks(folder, lines)) {
      if (options_.shard.count > 1) {
        return absl::FailedPreconditionError(absl::StrCat(
            run_,
            " does not hold what the masks are made from; write them once without --shard, "
            "or run egosieve reconstruct first"));
      }
      std::vector<std::string> words = {"reconstruct", run_, absl::StrCat("--input=", pictures)};
      // Products that reconstruct already made with its own thresholds stay.
      if (options_.mask.threshold) words.push_back("--what=probability");
      const ExitCode made = Step(std::move(words), false);
      if (made != ExitCode::kDone && made != ExitCode::kFramesFailed) return made;
    }
    Progress progress("masks", progress_, static_cast<int64_t>(lines.size()));
    EGOSIEVE_RETURN_IF_ERROR(output.Run(folder, lines, [&] {
      progress.Advance();
      return !InterruptionRequested();
    }));
    progress.Finish();
    Tell(output, images);
    return code;
  }

 private:
  void AddFileFlags(CLI::App& app) {
    app.add_option("--frames", options_.frames,
                   "Write the pictures, too, under the names that the masks go by; those of a "
                   "video are 000000.png and so on")
        ->type_name("DIR");
    app.add_option("--from_video", options_.video,
                   "The video that the pictures of INPUT were taken from: it is segmented instead "
                   "of them, and they are found in it by comparing thumbnails, whatever their size")
        ->type_name("FILE");
    app.add_option("--transforms", options_.transforms,
                   "nerfstudio's transforms.json; default: in the images' folder or above it")
        ->type_name("FILE");
    app.add_option("--truth", options_.truth,
                   "True masks, as for evaluate: prints how much of what moves is masked")
        ->type_name("DIR");
    app.add_flag("--overwrite", options_.overwrite,
                 "Replace files of the same names in --out and --frames; others stay");
  }

  void AddRunFlags(CLI::App& app) {
    app.add_option("--run", run_,
                   "The run folder for an input that is segmented, kept for the next call; "
                   "default: OUT.run")
        ->type_name("DIR");
    app.add_option("--input", moved_, "Where the run's input is now, if it was moved")
        ->type_name("PATH");
    app.add_option(
           "--shard", shard_,
           "Writes the K-th of N shares, from 1 on, of a run that has its masks; what other "
           "shares wrote stays")
        ->type_name("K/N");
    // Flags passed on to segment; its help describes them further.
    const auto pass = [&](const char* flag, const char* type, const char* help, auto& flags) {
      app.add_option(flag, flags[flag], help)->type_name(type);
    };
    pass("--profile", "default|paper|fast", "Accurate, as in the paper, or fast", passed_);
    pass("--fps", "FLOAT", "Frames per second of a folder of images: sets their times, skips none",
         passed_);
    pass("--times", "FILE", "The times of the images, one per line", passed_);
    pass("--camera", "FILE",
         "The focal length: a run's camera.json, COLMAP's cameras.txt, or a file of one's own with "
         "focal_pixels, width and height",
         passed_);
    pass("--ignore", "IMAGE", "Nothing moves where this image of the frames' size is not black",
         passed_);
    pass("--max_frames", "FRAMES", "Frames to segment at most", passed_);
    pass("--device", "DEVICE", "As for segment: see egosieve devices", passed_to_both_);
    pass("--threads", "NUMBER", "Threads, on the host and on a CPU as device", passed_to_both_);
  }

  static Words<Treatment> TreatmentWords() {
    return {{"keep", Treatment::kKeep}, {"mask", Treatment::kMask}};
  }

  absl::Status ResolveFlags() {
    if (unsure_ == Treatment::kMask) {
      if (options_.mask.threshold) {
        return absl::InvalidArgumentError(
            "--threshold and --unsure=mask exclude each other; leave one of them out");
      }
      options_.mask.threshold = ClassThresholds().static_below;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(options_.shard, ParseShard(shard_, kPieceFrames));
    options_.mask.numbers = HasNumbers(options_.format);
    options_.mask.own_vehicle =
        own_vehicle_ == Treatment::kMask ||
        (own_vehicle_ == Treatment::kDefault && IsForScenes(options_.format));
    return absl::OkStatus();
  }

  absl::Status CheckFlagsForRun() const {
    if (!run_.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat(input_, " is a run folder already; leave --run out"));
    }
    if (!options_.video.empty()) {
      return absl::InvalidArgumentError(absl::StrCat(
          input_,
          " is a run folder; --from_video takes the pictures as INPUT, and --run=", input_));
    }
    for (const auto& [flag, value] : passed_) {
      if (value) {
        return absl::InvalidArgumentError(
            absl::StrCat(input_, " is segmented already; leave ", flag, " out"));
      }
    }
    return absl::OkStatus();
  }

  absl::Status FindPictures(MaskExport& output) const {
    EGOSIEVE_ASSIGN_OR_RETURN(DriveInput video, OpenDriveInput(options_.video, 0));
    Progress progress("find pictures", progress_, video.frames->expected_frame_count());
    return output.FindPictures(*video.frames, [&] {
      progress.Advance();
      return !InterruptionRequested();
    });
  }

  // Runs another command of the program, which reports its own errors.
  ExitCode Step(std::vector<std::string> words, bool segments) const {
    const auto pass = [&](const auto& flags) {
      for (const auto& [flag, value] : flags) {
        if (value) words.push_back(absl::StrCat(flag, "=", *value));
      }
    };
    if (segments) pass(passed_);
    pass(passed_to_both_);
    if (progress_.mode != ProgressMode::kAuto) {
      words.push_back(progress_.mode == ProgressMode::kJson ? "--progress=json"
                                                            : "--progress=none");
    }
    if (result_.json) words.push_back("--json");
    CommandLine line("egosieve", "", kVersion);
    line.Add(MakeSegmentCommand());
    line.Add(MakeReconstructCommand());
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
    return IsReconstructed(folder) &&
           std::all_of(lines.begin(), lines.end(), [&](const FrameLine& line) {
             return std::filesystem::exists(MaskSource(folder, line.index, options_.mask));
           });
  }

  // `input`: as given, or as stored in the run.
  void Tell(const MaskExport& output, const std::string& input) const {
    std::string text = absl::StrCat(output.images(), " masks in ", options_.out,
                                    "; the run is kept in ", run_, "\n");
    if (output.is_video() && options_.frames.empty() && IsForScenes(options_.format)) {
      absl::StrAppend(&text,
                      "they go by the names 000000.png and so on; --frames=DIR writes the video's "
                      "pictures by these\n");
    }
    std::error_code error;
    const std::string images = !options_.frames.empty()                      ? options_.frames
                               : std::filesystem::is_directory(input, error) ? input
                                                                             : "IMAGES";
    absl::StrAppend(&text, HowToUse(options_.format, images, options_.out));
    nlohmann::ordered_json fields = {
        {"folder", options_.out}, {"run", run_}, {"images", output.images()}};
    if (const Coverage& coverage = output.coverage(); coverage.frames() > 0) {
      absl::StrAppend(&text, coverage.Describe(), "\n");
      fields["moving_masked"] = coverage.MovingMasked();
      fields["rest_masked"] = coverage.RestMasked();
    }
    result_.Tell(name(), fields, text);
    for (const std::string& warning : output.warnings()) Warn(warning);
  }

  std::string input_, run_, moved_, shard_;
  MaskExportOptions options_;
  Treatment unsure_ = Treatment::kDefault, own_vehicle_ = Treatment::kDefault;
  std::map<std::string, std::optional<std::string>> passed_, passed_to_both_;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeMasksCommand() { return std::make_unique<MasksCommand>(); }

}  // namespace egosieve::tools
