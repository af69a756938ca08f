#include "tools/run_folder/verdict.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "tools/run_folder/doubtful_frames.h"
#include "tools/run_folder/mover_tracks.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::tools {
namespace {

constexpr size_t kNamedMovers = 4;

}  // namespace

std::string DoubtLine(absl::Span<const FrameLine> lines) {
  DoubtfulFrames doubtful;
  for (const FrameLine& line : lines) doubtful.Add(line);
  if (const std::string few = doubtful.TooFewLearnt(); !few.empty()) {
    return absl::StrCat(few, "; the masks are not to be relied on");
  }
  return doubtful.count() > 0 ? doubtful.Sentence() : "no frame";
}

std::string MoversLine(absl::string_view tracks, absl::Span<const FrameLine> lines) {
  const std::vector<MoverTrack> movers = ReadMoverTracks(tracks);
  const size_t count = movers.size();
  if (count == 0) return absl::StrCat("nothing, in ", lines.size(), " frames");
  std::set<int64_t> frames;
  for (const MoverTrack& mover : movers) {
    for (const Sighting& sighting : mover.sightings) frames.insert(sighting.frame);
  }
  std::vector<std::string> named;
  for (size_t i = 0; i < std::min(count, kNamedMovers); ++i) {
    const std::vector<Sighting>& seen = movers[i].sightings;
    named.push_back(absl::StrFormat("number %d from %.1f to %.1f s", movers[i].number,
                                    seen.front().time_seconds, seen.back().time_seconds));
  }
  return absl::StrCat(count, count == 1 ? " mover" : " movers", ", in ", frames.size(), " of ",
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
  double areas = 0.0, probabilities = 0.0;
  for (const MoverTrack& mover : ReadMoverTracks(tracks)) {
    for (const Sighting& sighting : mover.sightings) {
      areas += sighting.area;
      probabilities += sighting.area * sighting.probability;
    }
  }
  if (areas > 0.0) {
    absl::StrAppendFormat(&text, "; a mover's pixels move with probability %.2f on average",
                          probabilities / areas);
  }
  return text;
}

}  // namespace egosieve::tools
