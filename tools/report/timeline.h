// When each mover was there: a drawing (SVG) with a row for each number, frames from left to right.
// Frames that were not learnt from, whose maps and numbers are less to be trusted, are grey
// columns.
#ifndef EGOSIEVE_TOOLS_REPORT_TIMELINE_H_
#define EGOSIEVE_TOOLS_REPORT_TIMELINE_H_

#include <string>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "tools/run_folder/frame_line.h"

namespace egosieve::tools {

// tracks: the text of tracks.csv; lines that cannot be read are passed over. Of more than 40 movers
// those that were there longest are drawn, and how many are left out is said. Empty without movers.
std::string MoverTimeline(absl::string_view tracks, absl::Span<const FrameLine> lines);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_REPORT_TIMELINE_H_
