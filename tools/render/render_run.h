// The run of `render`: draws a run's frames into images and a video.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/frame_range.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/render/overlay.h"
#include "tools/run_folder/frame_line.h"

namespace egosieve::tools {

struct RenderOptions {
  std::string directory;  // the run folder
  std::string input;      // where the run's input is now; empty: where run.json says
  OverlayOptions overlay;
  bool movers = true;    // as OverlaySource::ShowMovers
  bool images = false;   // render/NNNNNN.png
  bool video = true;     // overlay.mp4
  double rate_hz = 0.0;  // the video's; 0: the input's
  FrameRange range;
  ProgressFlag progress;
  ResultFlag result;
};

// Errors of usage, of the run folder, of the input and of the environment; Cancelled. Frames drawn
// before an error or an interruption are whole images and a whole video.
absl::StatusOr<ExitCode> RunRender(const RenderOptions& options);

// Frames per second of the run, from the median interval of its times; 10 if there is no clock.
// Between 1 and 60.
double FrameRate(const std::vector<FrameLine>& lines);

}  // namespace egosieve::tools
