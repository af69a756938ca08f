// A call of `segment`: all its flags, the checks of one flag with another, and its input.
#ifndef EGOSIEVE_TOOLS_SEGMENT_SEGMENT_CALL_H_
#define EGOSIEVE_TOOLS_SEGMENT_SEGMENT_CALL_H_

#include <CLI/CLI.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/cli/device_flag.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/threads_flag.h"
#include "tools/segment/camera_flags.h"
#include "tools/segment/drive_input.h"
#include "tools/segment/schedule_flags.h"
#include "tools/segment/segment_flags.h"
#include "vision/segmentation/online_segmenter.h"

namespace egosieve::tools {

struct SegmentCall {
  std::string input;
  std::string directory;            // the run folder
  bool overwrite = false;           // replace the run that the folder holds
  bool resume = false;              // continue it
  bool record = false;              // keep a stream's pictures
  bool allow_other_device = false;  // with `resume`
  std::string features;             // the folder of feature_dump.h; empty: none
  SegmentFlags segmenter;
  CameraFlags camera;
  ScheduleFlags schedule;
  ThreadsFlag threads;
  DeviceFlag device;
  ProgressFlag progress;
  ResultFlag result;

  void AddFlags(CLI::App& app);

  // InvalidArgument for a schedule that is none, and for flags about the run folder that exclude
  // each other.
  absl::Status Validate() const;
  // InvalidArgument for options that do not fit each other. `thread_count` is at least 1.
  absl::StatusOr<vision::OnlineSegmenterOptions> MakeOptions(int thread_count) const;

  // A file, folder or stream; remarks on videos are warnings on stderr. Errors of drive_input.h;
  // InvalidArgument for flags that do not belong to a stream, or only to one.
  absl::StatusOr<DriveInput> OpenInput() const;
  // InvalidArgument if maps would become pictures of the input, or `overwrite` would remove its
  // pictures.
  absl::Status CheckFolder(const DriveInput& drive) const;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_SEGMENT_CALL_H_
