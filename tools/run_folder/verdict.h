// What a run has shown, a line each: what moved, how sure that is, what is doubtful.
#pragma once

#include <string>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "tools/run_folder/frame_line.h"

namespace egosieve::tools {

// tracks: the text of tracks.csv. Of many movers those that are seen longest are named.
std::string MoversLine(absl::string_view tracks, absl::Span<const FrameLine> lines);
std::string CertaintyLine(absl::string_view tracks, absl::Span<const FrameLine> lines);
// "no frame" where nothing is.
std::string DoubtLine(absl::Span<const FrameLine> lines);

}  // namespace egosieve::tools
