// The frames of a run that a command works on, and what it says of those that have no map: a run
// with --learn_only or --every leaves maps to be made by infer.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_CHOSEN_LINES_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_CHOSEN_LINES_H_

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

// The run's lines in `range`. InvalidArgument where there are none, FailedPrecondition where the
// run has no frame at all.
absl::StatusOr<std::vector<FrameLine>> ChooseLines(const RunFolder& folder,
                                                   const FrameRange& range);

// FailedPrecondition where none of the lines, of which there is one at least, has a map: why, and
// the command that makes them. DataLoss where a map's file is missing or empty, likewise.
absl::Status CheckMaps(const RunFolder& folder, const RunDescription& description,
                       absl::Span<const FrameLine> lines);
// Of the whole run.
absl::Status CheckMaps(const RunFolder& folder);

// "5 of 8 frames have no map; egosieve infer DIR makes them": of the frames that could be read. ""
// where all have one.
std::string DescribeMissingMaps(const RunFolder& folder, const RunDescription& description,
                                absl::Span<const FrameLine> lines);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_CHOSEN_LINES_H_
