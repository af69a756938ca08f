#include "tools/synthesize/synthesize_command.h"

#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/progress.h"
#include "tools/synthesize/synthesize.h"
#include "tools/synthesize/synthesize_flags.h"
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

  void AddFlags(CLI::App& app) override { flags_.AddFlags(app); }

  absl::StatusOr<ExitCode> Run() override {
    if (flags_.list) {
      std::cout << ScenarioTable();
      return ExitCode::kDone;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(const SynthesizeOptions options, flags_.MakeOptions());
    Progress progress("synthesize", flags_.progress, options.rendering.frames);
    const absl::Status status =
        Synthesize(options, [&](int, int) { return progress.AdvanceUninterrupted(); });
    if (absl::IsNotFound(status)) return AsUsageError(status);  // of a scenario
    EGOSIEVE_RETURN_IF_ERROR(status);
    progress.Finish();
    flags_.result.Tell(name(),
                       {{"folder", options.output_folder},
                        {"frames", options.rendering.frames},
                        {"scenario", options.scenario}},
                       absl::StrCat(options.rendering.frames, " frames of scenario ",
                                    options.scenario, " in ", options.output_folder, "\n"));
    return ExitCode::kDone;
  }

 private:
  SynthesizeFlags flags_;
};

}  // namespace

std::unique_ptr<Command> MakeSynthesizeCommand() { return std::make_unique<SynthesizeCommand>(); }

}  // namespace egosieve::tools
