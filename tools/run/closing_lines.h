// What a run has shown, in five lines: what moved, how sure that is, what is doubtful, where the
// files are, what to do next.
#pragma once

#include <string>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "tools/run_folder/frame_line.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// tracks: the text of tracks.csv. Of many movers those that are seen longest are named.
std::string MoversLine(absl::string_view tracks, absl::Span<const FrameLine> lines);
std::string CertaintyLine(absl::string_view tracks, absl::Span<const FrameLine> lines);

// All five, each with its line break. Errors of the run folder.
absl::StatusOr<std::string> ClosingLines(const RunFolder& folder);

}  // namespace egosieve::tools
