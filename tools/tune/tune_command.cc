// egosieve tune: finds the kernels' best shapes for a device and stores them for later runs.
#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/tuning.h"
#include "tools/cli/checks.h"
#include "tools/cli/command.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/interruption.h"
#include "tools/cli/result_flag.h"
#include "tools/tune/tuner.h"

namespace egosieve::tools {
namespace {

class TuneCommand : public Command {
 public:
  std::string name() const override { return "tune"; }
  std::string summary() const override {
    return "Searches the kernels' tile shapes that are fastest on a device, and stores them.";
  }
  std::string example() const override { return "egosieve tune --device=gpu"; }

  void AddFlags(CLI::App& app) override {
    device_.AddFlag(app);
    app.add_option("--points", options_.training_points, "Points of the model that is timed")
        ->check(AtLeast<int64_t>(1))
        ->type_name("NUMBER");
    app.add_option("--repeats", options_.repeats, "Runs of each shape, the fastest of which counts")
        ->check(Between(1, 1000))
        ->type_name("NUMBER");
    app.add_flag("--dry_run", dry_run_, "Search, but store nothing");
    app.add_flag("--quiet", quiet_, "Do not print the shapes that are timed");
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    EndOnInterruptions();
    EGOSIEVE_ASSIGN_OR_RETURN(const OpenedDevice device, device_.Open());
    options_.device = std::to_string(device.info.index);
    if (!quiet_) {
      options_.progress = [](const std::string& line) { std::cerr << line << std::endl; };
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const tune::TuneResult result, tune::Tune(options_));
    std::string text = absl::StrFormat(
        "%s: %d shapes timed, %d dropped\n"
        "mean      %.2f ms before, %.2f ms now\n"
        "variance  %.2f ms before, %.2f ms now\n",
        result.device, result.shapes_timed, result.shapes_dropped, 1e3 * result.mean_seconds_before,
        1e3 * result.mean_seconds_after, 1e3 * result.variance_seconds_before,
        1e3 * result.variance_seconds_after);
    nlohmann::ordered_json kept;
    if (dry_run_) {
      absl::StrAppend(&text, kernels::FormatTuning(result.after));
    } else {
      EGOSIEVE_RETURN_IF_ERROR(kernels::SaveTuning(device.info, result.after));
      kept = kernels::TuningPath(device.info);
      absl::StrAppend(&text, "kept in ", kernels::TuningPath(device.info), "\n");
    }
    result_.Tell(name(),
                 {{"device", result.device},
                  {"shapes_timed", result.shapes_timed},
                  {"shapes_dropped", result.shapes_dropped},
                  {"mean_seconds_before", result.mean_seconds_before},
                  {"mean_seconds_after", result.mean_seconds_after},
                  {"variance_seconds_before", result.variance_seconds_before},
                  {"variance_seconds_after", result.variance_seconds_after},
                  {"table", kernels::FormatTuning(result.after)},
                  {"kept_in", kept}},
                 text);
    return ExitCode::kDone;
  }

 private:
  DeviceFlag device_;
  tune::TuneOptions options_;
  bool dry_run_ = false, quiet_ = false;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakeTuneCommand() { return std::make_unique<TuneCommand>(); }

}  // namespace egosieve::tools
