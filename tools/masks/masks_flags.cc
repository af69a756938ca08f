#include "tools/masks/masks_flags.h"

#include <CLI/CLI.hpp>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/output_folder.h"
#include "tools/refine/full_maps.h"

namespace egosieve::tools {
namespace {

Words<Treatment> TreatmentWords() {
  return {{"keep", Treatment::kKeep}, {"mask", Treatment::kMask}};
}

}  // namespace

void MasksFlags::AddFlags(CLI::App& app) {
  app.add_option("INPUT", input,
                 "A video, a folder of images or a glob, which are segmented first; or a run "
                 "folder")
      ->required()
      ->type_name("")
      ->configurable(false);
  app.add_option("-o,--out", options.out,
                 "The folder to write the masks to; default: out/NAME.masks of INPUT")
      ->type_name("DIR");
  AddWords(app, "--for", options.format, MaskFormatWords(), "The program that reads the masks");
  app.add_option("--dilate", options.mask.dilate_pixels,
                 "Also mask pixels nearer than this to a mover; default: 0")
      ->type_name("PIXELS");
  app.add_option("--shadow_margin", options.mask.shadow_margin_pixels,
                 "Also mask the shadows that movers cast, up to this distance from them: what is "
                 "darker than the ground around it and begins at their feet; default: 0, none")
      ->type_name("PIXELS");
  app.add_option("--threshold", options.mask.threshold,
                 "Masks where the probability of moving is at least this; default: the masks of "
                 "refine, by its own thresholds")
      ->type_name("P");
  AddWords(app, "--unsure", unsure, TreatmentWords(),
           absl::StrCat(
               "Pixels that are neither clearly moving nor clearly static; mask: as --threshold=",
               ClassThresholds().static_below, "; default: keep"));
  AddWords(app, "--own_vehicle", own_vehicle, TreatmentWords(),
           "The camera's own vehicle, where it was found, and what --ignore names; default: mask "
           "it for programs that build a scene, keep it for others");
  app.add_option("--also", options.also,
                 "Own masks to unite with these, not 0 where masked: a folder with IMAGE.png or "
                 "NAME.png, or one picture for all images")
      ->type_name("PATH");
  app.add_flag("--invert", options.invert,
               "Exchange what is masked and what is not; not for davis, coco and mots");
  app.add_option("--frames", options.frames,
                 "Write the pictures, too, under the names that the masks go by; those of a "
                 "video are 000000.png and so on")
      ->type_name("DIR");
  app.add_option("--from_video", options.video,
                 "The video that the pictures of INPUT were taken from: it is segmented instead "
                 "of them, and they are found in it by comparing thumbnails, whatever their size")
      ->type_name("FILE");
  app.add_option("--transforms", options.transforms,
                 "nerfstudio's transforms.json; default: in the images' folder or above it")
      ->type_name("FILE");
  app.add_option("--undistort", options.undistort,
                 "Masks of COLMAP's undistorted pictures: the output_path of image_undistorter; "
                 "with --sparse")
      ->type_name("DENSE");
  app.add_option("--sparse", options.sparse,
                 "For --undistort: the input_path of image_undistorter, COLMAP's model of the "
                 "original pictures")
      ->type_name("SPARSE");
  app.add_flag(
      "--overwrite", options.overwrite,
      "Replace files of the same names in --out and --frames; others stay. Not needed where the "
      "same call was interrupted");
  app.add_option("--run", run,
                 "The run folder for an input that is segmented, kept for the next call; "
                 "default: OUT.run")
      ->type_name("DIR");
  app.add_option("--input", moved, "Where the run's input is now, if it was moved")
      ->type_name("PATH");
  // Flags passed on to segment; its help describes them further.
  const auto pass = [&](const char* flag, const char* type, const char* help, auto& flags) {
    app.add_option(flag, flags[flag], help)->type_name(type);
  };
  pass("--profile", "default|paper|fast", "Accurate, as in the paper, or fast", passed);
  pass("--fps", "FLOAT", "Frames per second of a folder of images: sets their times, skips none",
       passed);
  pass("--times", "FILE", "The times of the images, one per line", passed);
  pass("--camera", "FILE",
       "The lens: a run's camera.json, JSON of focal_pixels, width and height, COLMAP's "
       "cameras.txt, "
       "or YAML of ROS or Kalibr",
       passed);
  pass("--ignore", "IMAGE", "Nothing moves where this image of the frames' size is not black",
       passed);
  pass("--max_frames", "FRAMES", "Frames to segment at most", passed);
  pass("--device", "DEVICE", "As for segment: see egosieve devices", passed);
  pass("--threads", "NUMBER", "Threads, on the host and on a CPU as device", passed_to_both);
  progress.AddFlag(app);
  result.AddFlag(app);
}

absl::Status MasksFlags::Resolve() {
  if (options.out.empty()) options.out = DefaultFolder(input) + ".masks";
  if (unsure == Treatment::kMask) {
    if (options.mask.threshold) {
      return absl::InvalidArgumentError(
          "--threshold and --unsure=mask exclude each other; leave one of them out");
    }
    options.mask.threshold = ClassThresholds().static_below;
  }
  options.mask.numbers = HasNumbers(options.format);
  options.mask.own_vehicle = own_vehicle == Treatment::kMask ||
                             (own_vehicle == Treatment::kDefault && IsForScenes(options.format));
  return absl::OkStatus();
}

absl::Status MasksFlags::CheckForRun() const {
  if (!run.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(input, " is a run folder already; leave --run out"));
  }
  if (!options.video.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        input, " is a run folder; --from_video takes the pictures as INPUT, and --run=", input));
  }
  for (const auto& [flag, value] : passed) {
    if (value) {
      return absl::InvalidArgumentError(
          absl::StrCat(input, " is segmented already; leave ", flag, " out"));
    }
  }
  return absl::OkStatus();
}

}  // namespace egosieve::tools
