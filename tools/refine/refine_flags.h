// The flags of `refine`: which frames of a run are refined, how, and what is written.
#ifndef EGOSIEVE_TOOLS_REFINE_REFINE_FLAGS_H_
#define EGOSIEVE_TOOLS_REFINE_REFINE_FLAGS_H_

#include <string>

#include "absl/status/statusor.h"
#include "tools/cli/device_flag.h"
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

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_REFINE_REFINE_FLAGS_H_
