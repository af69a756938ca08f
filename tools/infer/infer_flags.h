// The flags of `infer`: which maps of a run are made, where, and how finely.
#ifndef EGOSIEVE_TOOLS_INFER_INFER_FLAGS_H_
#define EGOSIEVE_TOOLS_INFER_INFER_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "tools/cli/device_flag.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/threads_flag.h"
#include "tools/infer/map_target.h"

namespace egosieve::tools {

struct InferFlags {
  MapTarget target;
  std::string input;  // where the run's input is now; empty: where run.json says
  FrameRange range;
  int64_t every = 1;  // frames, from the run's first on
  int stride = 0;     // pixels; 0: the run's
  ThreadsFlag threads;
  DeviceFlag device;
  ProgressFlag progress;
  ResultFlag result;

  void AddFlags(CLI::App& app);
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_INFER_INFER_FLAGS_H_
