// The flags of `reconstruct`: which frames of a run are reconstructed, how, and what is written.
#ifndef EGOSIEVE_TOOLS_RECONSTRUCT_RECONSTRUCT_FLAGS_H_
#define EGOSIEVE_TOOLS_RECONSTRUCT_RECONSTRUCT_FLAGS_H_

#include <string>

#include "absl/status/statusor.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/threads_flag.h"
#include "tools/reconstruct/reconstruct_run.h"

namespace CLI {
class App;
}

namespace egosieve::tools {

struct ReconstructFlags {
  std::string directory;
  std::string what = ProductChoice().ToText();
  ReconstructOptions options;  // but its `what`
  FrameRange range;
  ThreadsFlag threads;
  DeviceFlag device;
  ProgressFlag progress;
  ResultFlag result;

  void AddFlags(CLI::App& app);
  // The options with `what`. InvalidArgument for values out of range.
  absl::StatusOr<ReconstructOptions> MakeOptions() const;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RECONSTRUCT_RECONSTRUCT_FLAGS_H_
