#include "tools/run/closing_lines.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/doubtful_frames.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::tools {
namespace {

constexpr size_t kNamedMovers = 4;

struct Mover {
  int number = 0;
  int64_t frames = 0;
  double first_seconds = 0.0, last_seconds = 0.0;
};

struct Movers {
  std::vector<Mover> longest_first;
  int64_t frames = 0;             // with a mover
  double mean_probability = 0.0;  // of the movers' pixels
};

// Rows that are no rows of tracks.csv are left out.
Movers ReadMovers(absl::string_view tracks) {
  Movers movers;
  std::map<int, Mover> by_number;
  int64_t last_frame = -1;
  double areas = 0.0, probabilities = 0.0;
  for (const absl::string_view row : absl::StrSplit(tracks, '\n', absl::SkipEmpty())) {
    const std::vector<absl::string_view> fields = absl::StrSplit(row, ',');
    int64_t frame = 0;
    int number = 0;
    double seconds = 0.0, area = 0.0, probability = 0.0;
    if (fields.size() < 9 || !absl::SimpleAtoi(fields[0], &frame) ||
        !absl::SimpleAtod(fields[1], &seconds) || !absl::SimpleAtoi(fields[2], &number) ||
        !absl::SimpleAtod(fields[7], &area) || !absl::SimpleAtod(fields[8], &probability)) {
      continue;
    }
    Mover& mover = by_number[number];
    if (mover.frames++ == 0) mover = {number, 1, seconds, seconds};
    mover.last_seconds = seconds;
    movers.frames += frame != last_frame;
    last_frame = frame;
    areas += area;
    probabilities += area * probability;
  }
  for (const auto& [number, mover] : by_number) movers.longest_first.push_back(mover);
  std::stable_sort(movers.longest_first.begin(), movers.longest_first.end(),
                   [](const Mover& a, const Mover& b) { return a.frames > b.frames; });
  if (areas > 0.0) movers.mean_probability = probabilities / areas;
  return movers;
}

std::string DoubtLine(const DoubtfulFrames& doubtful) {
  if (const std::string few = doubtful.TooFewLearnt(); !few.empty()) {
    return absl::StrCat(few, "; the masks are not to be relied on");
  }
  return doubtful.count() > 0 ? doubtful.Sentence() : "no frame";
}

}  // namespace

std::string MoversLine(absl::string_view tracks, absl::Span<const FrameLine> lines) {
  const Movers movers = ReadMovers(tracks);
  const size_t count = movers.longest_first.size();
  if (count == 0) return absl::StrCat("nothing, in ", lines.size(), " frames");
  std::vector<std::string> named;
  for (size_t i = 0; i < std::min(count, kNamedMovers); ++i) {
    const Mover& mover = movers.longest_first[i];
    named.push_back(absl::StrFormat("number %d from %.1f to %.1f s", mover.number,
                                    mover.first_seconds, mover.last_seconds));
  }
  return absl::StrCat(count, count == 1 ? " mover" : " movers", ", in ", movers.frames, " of ",
                      lines.size(), " frames", count > kNamedMovers ? "; longest: " : ": ",
                      absl::StrJoin(named, ", "));
}

std::string CertaintyLine(absl::string_view tracks, absl::Span<const FrameLine> lines) {
  std::vector<double> overlaps;
  for (const FrameLine& line : lines) {
    if (std::isfinite(line.expected_overlap)) overlaps.push_back(line.expected_overlap);
  }
  std::string text = overlaps.empty()
                         ? "unknown"
                         : absl::StrFormat(
                               "by their own probabilities the maps overlap what moves "
                               "with an IoU of %.2f (median)",
                               vision::MedianInPlace(overlaps));
  if (const double mean = ReadMovers(tracks).mean_probability; mean > 0.0) {
    absl::StrAppendFormat(&text, "; a mover's pixels move with probability %.2f on average", mean);
  }
  return text;
}

absl::StatusOr<std::string> ClosingLines(const RunFolder& folder) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string tracks, ReadFile(folder.File("tracks.csv")));
  std::vector<std::string> files;
  for (const char* name : {"report.html", "overlay.mp4", "overlay.avi"}) {
    if (std::filesystem::exists(folder.File(name))) files.push_back(name);
  }
  DoubtfulFrames doubtful;
  for (const FrameLine& line : lines) doubtful.Add(line);
  return absl::StrCat("moved:     ", MoversLine(tracks, lines),
                      "\nsure:      ", CertaintyLine(tracks, lines),
                      "\ndoubtful:  ", DoubtLine(doubtful), "\nfiles:     ", folder.path(), ": ",
                      absl::StrJoin(files, ", "),
                      ", masks/ and ids/ (a picture per frame), tracks.csv\nnext:      ",
                      doubtful.count() > 0 ? "look at the doubtful frames in " : "open ",
                      folder.File("report.html"), "; masks for other programs: egosieve masks ",
                      folder.path(), " --for=colmap\n");
}

}  // namespace egosieve::tools
