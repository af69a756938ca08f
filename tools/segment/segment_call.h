// A call of `segment`: all its flags, the checks of one flag with another, and its input.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/threads_flag.h"
#include "tools/run_folder/frame_line.h"
#include "tools/segment/drive_input.h"
#include "tools/segment/segment_camera.h"
#include "tools/segment/segment_options.h"

namespace egosieve::tools {

struct SegmentCall {
  std::string input;
  std::string directory;            // the run folder; not empty after Resolve
  bool overwrite = false;           // replace the run that the folder holds
  bool resume = false;              // continue it
  bool record = false;              // keep a stream's pictures
  bool allow_other_device = false;  // with `resume`
  GivenOptions given;
  SegmentSettings settings;  // after Resolve
  SegmentCamera camera;
  ThreadsFlag threads;
  DeviceFlag device;
  ProgressFlag progress;
  ResultFlag result;
  // Called with every frame that is written, if there is one. What it returns is said beside the
  // progress, if not empty; its error ends the run.
  std::function<absl::StatusOr<std::string>(const FrameLine&)> watch;

  void AddFlags(CLI::App& app);

  // Makes `settings` of what was given; InvalidArgument for what does not fit together.
  absl::Status Resolve();

  // A file, folder or stream; remarks on videos are warnings on stderr. Errors of drive_input.h;
  // InvalidArgument for flags that do not belong to a stream, or only to one.
  absl::StatusOr<DriveInput> OpenInput() const;
  // InvalidArgument if maps would become pictures of the input, or `overwrite` would remove its
  // pictures.
  absl::Status CheckFolder(const DriveInput& drive) const;
};

}  // namespace egosieve::tools
