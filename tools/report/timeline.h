// When each mover was visible: a drawing (SVG) with one row per number, frames from left to right.
// Grey columns are frames that were not learnt from; their maps and numbers are less reliable.
#pragma once

#include <string>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "tools/run_folder/frame_line.h"

namespace egosieve::tools {

// tracks: the text of tracks.csv; unreadable lines are skipped. If there are more than 40 movers,
// the longest visible ones are drawn, and the number of the others is stated. Empty without movers.
std::string MoverTimeline(absl::string_view tracks, absl::Span<const FrameLine> lines);

}  // namespace egosieve::tools
