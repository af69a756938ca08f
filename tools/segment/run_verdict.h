// Warnings and exit code of a run that reached its end: kFramesFailed if frames could not be read,
// if a video ended early, or if the model learnt from nothing or from fewer than half of the frames
// (tools/run_folder/doubtful_frames.h).
#pragma once

#include <string>
#include <vector>

#include "tools/cli/exit_code.h"
#include "tools/segment/drive_writer.h"

namespace egosieve::tools {

struct RunVerdict {
  ExitCode code = ExitCode::kDone;
  std::vector<std::string> warnings;  // one line each
};

// end_warning: EndOfFrames::warning, empty if there is none.
RunVerdict JudgeRun(const DriveWriter::Counts& counts, const std::string& end_warning);

}  // namespace egosieve::tools
