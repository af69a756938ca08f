// The flags of `refine`: which frames of a run are refined, how, and what is written.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/threads_flag.h"
#include "tools/refine/refine_run.h"

namespace CLI {
class App;
}

namespace egosieve::tools {

struct RefineFlags {
  std::string directory;
  std::string what = ProductChoice().ToText();
  RefineOptions options;  // but its `what`
  FrameRange range;
  ThreadsFlag threads;
  DeviceFlag device;
  ProgressFlag progress;
  ResultFlag result;

  void AddFlags(CLI::App& app);
  // The options with `what`. InvalidArgument for values out of range.
  absl::StatusOr<RefineOptions> MakeOptions() const;
};

// Errors of usage, of the run folder, of the input and of the environment; Cancelled, with whole
// chunks so far.
absl::StatusOr<ExitCode> RunRefine(const RefineFlags& flags);

}  // namespace egosieve::tools
