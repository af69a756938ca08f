#include "tools/synthesize/synthesize_flags.h"

#include <CLI/CLI.hpp>
#include <cmath>

#include "absl/status/status.h"
#include "tools/cli/checks.h"
#include "tools/cli/switch_flag.h"
#include "vision/synthetic/street.h"

namespace egosieve::tools {

void SynthesizeFlags::AddFlags(CLI::App& app) {
  vision::ScenarioOptions& rendering = options.rendering;
  app.add_option("--scenario", options.scenario, "What happens; --list names them")
      ->capture_default_str()
      ->type_name("NAME");
  app.add_flag("--list", list, "List the scenarios and do nothing else");
  app.add_option(
         "-o,--out", options.output_folder,
         "Folder for frames/, masks/, ids/, poses.txt, camera.json and scene.json; default: "
         "out/SCENARIO")
      ->type_name("DIR");
  app.add_option("--seed", options.seed,
                 "Seed of town and traffic; 1 to 9 are for choosing constants, 100 to 109 for "
                 "figures that are reported")
      ->capture_default_str();
  app.add_option("--frames", rendering.frames,
                 "How many; a drive of another length has other traffic, also in its first frames")
      ->capture_default_str();
  app.add_option("--seconds", seconds, "How long, instead of --frames; 0: --frames")
      ->check(AtLeast(0.0))
      ->capture_default_str();
  app.add_option("--fps,--frames_per_second", rendering.frames_per_second,
                 "Frame rate; the same --seconds at another rate are the same drive")
      ->capture_default_str();
  app.add_option("--width", rendering.width_pixels, "Pixels")->capture_default_str();
  app.add_option("--height", rendering.height_pixels, "Pixels")->capture_default_str();
  app.add_option("--field_of_view", rendering.field_of_view_degrees, "Horizontal, in degrees")
      ->capture_default_str();
  app.add_option("--radial", rendering.radial,
                 "The lens's radial distortion k: r becomes r (1 + k r^2), r in focal lengths")
      ->capture_default_str();
  app.add_option("--exposure_swing", rendering.exposure_swing,
                 "Variation of the exposure: amplitude of its logarithm")
      ->capture_default_str();
  AddWords(
      app, "--compression", options.compression,
      {{"none", Compression::kNone}, {"jpeg", Compression::kJpeg}, {"h264", Compression::kH264}},
      "Artefacts added to the pictures: those of a JPEG of low quality, or of a video");
  app.add_option("--threads", rendering.threads, "The result does not depend on them")
      ->capture_default_str();
  app.add_flag("--video", options.video, "Write video.mp4 (lossy) instead of frames/");
  app.add_flag("--overwrite", options.overwrite, "Replace a former drive in the folder");
  AddSwitch(app, "--noise", "--no_noise", rendering.noise, "The sensor's noise");
  AddSwitch(app, "--motion_blur", "--no_motion_blur", rendering.motion_blur,
            "Blur while the shutter is open");
  progress.AddFlag(app);
  result.AddFlag(app);
}

absl::StatusOr<SynthesizeOptions> SynthesizeFlags::MakeOptions() const {
  SynthesizeOptions made = options;
  if (made.output_folder.empty()) made.output_folder = "out/" + made.scenario;
  if (seconds > 0.0) {
    made.rendering.frames =
        static_cast<int>(std::lround(seconds * made.rendering.frames_per_second));
  }
  return made;
}

}  // namespace egosieve::tools
