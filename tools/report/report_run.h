// The run of `report`: collects what a run folder holds and writes its report.html.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/render/overlay.h"

namespace egosieve::tools {

struct ReportOptions {
  std::string directory;  // the run folder
  std::string input;      // where the run's input is now; empty: where run.json says
  int64_t pictures = 12;  // overlays on the page
  OverlayOptions overlay;
  ProgressFlag progress;
  ResultFlag result;
};

// Without its evaluation or pictures, the page says what is missing. Errors of usage, of the run
// folder and of the environment; Cancelled, with nothing written.
absl::StatusOr<ExitCode> RunReport(const ReportOptions& options);

}  // namespace egosieve::tools
