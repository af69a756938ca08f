// `egosieve synthesize`: writes a synthetic drive with its truth (synthesize.h).
#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/checks.h"
#include "tools/cli/command.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/synthesize/synthesize.h"
#include "vision/synthetic/street.h"

namespace egosieve::tools {
namespace {

// "street  a town drive: ...", one line per scenario.
std::string ScenarioTable() {
  std::string table;
  for (const vision::ScenarioDescription& scenario : vision::Scenarios()) {
    absl::StrAppendFormat(&table, "%-18s%s\n", std::string(scenario.name),
                          std::string(scenario.summary));
  }
  return table;
}

class SynthesizeCommand : public Command {
 public:
  std::string name() const override { return "synthesize"; }
  std::string summary() const override {
    return "Writes a synthetic drive with exact masks of what moves.";
  }
  std::string example() const override {
    return "egosieve synthesize --scenario=crossing --seed=3 --out=out/crossing\n"
           "egosieve synthesize --list";
  }

  void AddFlags(CLI::App& app) override {
    vision::ScenarioOptions& rendering = options_.rendering;
    app.add_option("--scenario", options_.scenario, "What happens; --list names them")
        ->capture_default_str()
        ->type_name("NAME");
    app.add_flag("--list", list_, "List the scenarios and do nothing else");
    app.add_option(
           "-o,--out", options_.output_folder,
           "Folder for frames/, masks/, ids/, poses.txt, camera.json and scene.json; default: "
           "out/SCENARIO")
        ->type_name("DIR");
    app.add_option("--seed", options_.seed,
                   "Seed of town and traffic; 1 to 9 are for choosing constants, 100 to 109 for "
                   "figures that are reported")
        ->capture_default_str();
    app.add_option(
           "--frames", rendering.frames,
           "How many; a drive of another length has other traffic, also in its first frames")
        ->capture_default_str();
    app.add_option("--seconds", seconds_, "How long, instead of --frames; 0: --frames")
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
        app, "--compression", options_.compression,
        {{"none", Compression::kNone}, {"jpeg", Compression::kJpeg}, {"h264", Compression::kH264}},
        "Artefacts added to the pictures: those of a JPEG of low quality, or of a video");
    app.add_option("--threads", rendering.threads, "The result does not depend on them")
        ->capture_default_str();
    app.add_flag("--video", options_.video, "Write video.mp4 (lossy) instead of frames/");
    app.add_flag("--overwrite", options_.overwrite, "Replace a former drive in the folder");
    AddSwitch(app, "--noise", "--no_noise", rendering.noise, "The sensor's noise");
    AddSwitch(app, "--motion_blur", "--no_motion_blur", rendering.motion_blur,
              "Blur while the shutter is open");
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    if (list_) {
      std::cout << ScenarioTable();
      return ExitCode::kDone;
    }
    vision::ScenarioOptions& rendering = options_.rendering;
    if (options_.output_folder.empty()) options_.output_folder = "out/" + options_.scenario;
    if (seconds_ > 0.0) {
      rendering.frames = static_cast<int>(std::lround(seconds_ * rendering.frames_per_second));
    }
    Progress progress("synthesize", progress_, rendering.frames);
    const absl::Status status =
        Synthesize(options_, [&](int, int) { return progress.AdvanceUninterrupted(); });
    if (absl::IsNotFound(status)) return AsUsageError(status);  // of a scenario
    EGOSIEVE_RETURN_IF_ERROR(status);
    progress.Finish();
    result_.Tell(name(),
                 {{"folder", options_.output_folder},
                  {"frames", rendering.frames},
                  {"scenario", options_.scenario}},
                 absl::StrCat(rendering.frames, " frames of scenario ", options_.scenario, " in ",
                              options_.output_folder, "\n"));
    return ExitCode::kDone;
  }

 private:
  SynthesizeOptions options_;
  bool list_ = false;     // the scenarios, and nothing else
  double seconds_ = 0.0;  // instead of a number of frames; 0: that number
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeSynthesizeCommand() { return std::make_unique<SynthesizeCommand>(); }

}  // namespace egosieve::tools
