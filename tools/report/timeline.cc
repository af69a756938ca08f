#include "tools/report/timeline.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "tools/render/overlay.h"
#include "tools/run_folder/doubtful_frames.h"

namespace egosieve::tools {
namespace {

constexpr size_t kMostRows = 40;
constexpr double kWidth = 1000.0, kLeft = 50.0, kRowHeight = 14.0;

struct Mover {
  int number = 0;
  std::vector<int64_t> frames;  // increasing
};

// The longest visible kMostRows movers, in the order of their first frames.
std::vector<Mover> ReadMovers(absl::string_view tracks, size_t* left_out) {
  std::map<int, Mover> by_number;
  for (const absl::string_view row : absl::StrSplit(tracks, '\n', absl::SkipEmpty())) {
    const std::vector<absl::string_view> fields = absl::StrSplit(row, ',');
    int64_t frame = 0;
    int number = 0;
    if (fields.size() < 3 || !absl::SimpleAtoi(fields[0], &frame) ||
        !absl::SimpleAtoi(fields[2], &number)) {
      continue;
    }
    by_number[number].number = number;
    by_number[number].frames.push_back(frame);
  }
  std::vector<Mover> movers;
  for (auto& [number, mover] : by_number) movers.push_back(std::move(mover));
  std::stable_sort(movers.begin(), movers.end(), [](const Mover& a, const Mover& b) {
    return a.frames.size() > b.frames.size();
  });
  *left_out = movers.size() - std::min(movers.size(), kMostRows);
  if (*left_out > 0) movers.resize(kMostRows);
  std::stable_sort(movers.begin(), movers.end(), [](const Mover& a, const Mover& b) {
    return a.frames.front() < b.frames.front();
  });
  return movers;
}

}  // namespace

std::string MoverTimeline(absl::string_view tracks, absl::Span<const FrameLine> lines) {
  size_t left_out = 0;
  const std::vector<Mover> movers = ReadMovers(tracks, &left_out);
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
    const Mover& mover = movers[row];
    const double top = kRowHeight * static_cast<double>(row);
    const cv::Vec3b colour = MoverColour(mover.number);
    absl::StrAppendFormat(&svg, "<text x=\"%g\" y=\"%g\" text-anchor=\"end\">%d</text>\n",
                          kLeft - 6.0, top + 11.0, mover.number);
    for (size_t i = 0; i < mover.frames.size();) {
      size_t end = i + 1;
      while (end < mover.frames.size() && mover.frames[end] == mover.frames[end - 1] + 1) ++end;
      absl::StrAppendFormat(
          &svg,
          "<rect x=\"%.2f\" y=\"%g\" width=\"%.2f\" height=\"%g\" fill=\"#%02x%02x%02x\">"
          "<title>%d: frames %d to %d</title></rect>\n",
          place(mover.frames[i]), top + 2.0,
          scale * static_cast<double>(mover.frames[end - 1] - mover.frames[i] + 1),
          kRowHeight - 4.0, colour[2], colour[1], colour[0], mover.number, mover.frames[i],
          mover.frames[end - 1]);
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
