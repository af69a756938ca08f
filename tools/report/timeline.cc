#include "tools/report/timeline.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tools/render/overlay.h"
#include "tools/run_folder/doubtful_frames.h"
#include "tools/run_folder/mover_tracks.h"

namespace egosieve::tools {
namespace {

constexpr size_t kMostRows = 40;
constexpr double kWidth = 1000.0, kLeft = 50.0, kRowHeight = 14.0;

// The longest visible kMostRows movers, in the order of their first frames.
std::vector<MoverTrack> ShownMovers(absl::string_view tracks, size_t* left_out) {
  std::vector<MoverTrack> movers = ReadMoverTracks(tracks);
  *left_out = movers.size() - std::min(movers.size(), kMostRows);
  movers.resize(movers.size() - *left_out);
  std::ranges::stable_sort(movers, {},
                           [](const MoverTrack& mover) { return mover.sightings.front().frame; });
  return movers;
}

}  // namespace

std::string MoverTimeline(absl::string_view tracks, absl::Span<const FrameLine> lines) {
  size_t left_out = 0;
  const std::vector<MoverTrack> movers = ShownMovers(tracks, &left_out);
  if (movers.empty() || lines.empty()) return "";
  const int64_t first = lines.front().index, last = lines.back().index;
  const double scale = (kWidth - kLeft) / static_cast<double>(last - first + 1);
  const auto place = [&](int64_t frame) {
    return kLeft + scale * static_cast<double>(frame - first);
  };
  const double height = kRowHeight * static_cast<double>(movers.size());
  std::string svg = absl::StrFormat(
      "<svg class=\"timeline\" viewBox=\"0 0 %g %g\" role=\"img\" aria-label=\"when each mover was "
      "there\">\n",
      kWidth, height + 18.0);
  for (const FrameLine& line : lines) {
    if (DoubtOf(line).empty()) continue;
    absl::StrAppendFormat(
        &svg, "<rect x=\"%.2f\" y=\"0\" width=\"%.2f\" height=\"%g\" fill=\"#e3e6ea\"/>\n",
        place(line.index), scale, height);
  }
  for (size_t row = 0; row < movers.size(); ++row) {
    const MoverTrack& mover = movers[row];
    const double top = kRowHeight * static_cast<double>(row);
    const cv::Vec3b colour = MoverColour(mover.number);
    absl::StrAppendFormat(&svg, "<text x=\"%g\" y=\"%g\" text-anchor=\"end\">%d</text>\n",
                          kLeft - 6.0, top + 11.0, mover.number);
    const std::vector<Sighting>& seen = mover.sightings;
    for (size_t i = 0; i < seen.size();) {
      size_t end = i + 1;
      while (end < seen.size() && seen[end].frame == seen[end - 1].frame + 1) ++end;
      absl::StrAppendFormat(
          &svg,
          "<rect x=\"%.2f\" y=\"%g\" width=\"%.2f\" height=\"%g\" fill=\"#%02x%02x%02x\">"
          "<title>%d: frames %d to %d</title></rect>\n",
          place(seen[i].frame), top + 2.0,
          scale * static_cast<double>(seen[end - 1].frame - seen[i].frame + 1), kRowHeight - 4.0,
          colour[2], colour[1], colour[0], mover.number, seen[i].frame, seen[end - 1].frame);
      i = end;
    }
  }
  absl::StrAppendFormat(&svg,
                        "<text x=\"%g\" y=\"%g\">frame %d</text><text x=\"%g\" y=\"%g\" "
                        "text-anchor=\"end\">%d</text>\n</svg>\n",
                        kLeft, height + 14.0, first, kWidth, height + 14.0, last);
  if (left_out > 0) {
    absl::StrAppend(&svg, "<p class=\"note\">", left_out,
                    " movers that were there shorter are in "
                    "tracks.csv.</p>\n");
  }
  return svg;
}

}  // namespace egosieve::tools
