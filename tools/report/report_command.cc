// egosieve report DIR: report.html.
#include <CLI/CLI.hpp>
#include <string>

#include "tools/cli/checks.h"
#include "tools/cli/command.h"
#include "tools/cli/object_flags.h"
#include "tools/report/report_run.h"

namespace egosieve::tools {
namespace {

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
    options_.device.AddFlag(app);
    options_.progress.AddFlag(app);
    options_.result.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override { return RunReport(options_); }

 private:
  ReportOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeReportCommand() { return std::make_unique<ReportCommand>(); }

}  // namespace egosieve::tools
