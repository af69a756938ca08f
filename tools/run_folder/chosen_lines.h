// The frames of a run that a command works on, and messages about frames without a map.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "tools/cli/frame_range.h"
#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_description.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// The run's lines in `range`. InvalidArgument if there are none; FailedPrecondition if the run has
// no frame at all.
absl::StatusOr<std::vector<FrameLine>> ChooseLines(const RunFolder& folder,
                                                   const FrameRange& range);

// `lines` has at least one line. FailedPrecondition if no line has a map: the message gives the
// reason and the command that makes the maps. DataLoss, with the same hint, if a map's file is
// missing or empty.
absl::Status CheckMaps(const RunFolder& folder, absl::Span<const FrameLine> lines);

// "5 of 8 frames have no map; egosieve segment --resume ... makes them". Counts only frames that
// could be read. "" if all have a map.
std::string DescribeMissingMaps(const RunFolder& folder, absl::Span<const FrameLine> lines);

}  // namespace egosieve::tools
