#include "tools/run_folder/mover_tracks.h"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"

namespace egosieve::tools {

std::vector<MoverTrack> ReadMoverTracks(absl::string_view tracks) {
  std::map<int, MoverTrack> by_number;
  for (const absl::string_view row : absl::StrSplit(tracks, '\n', absl::SkipEmpty())) {
    const std::vector<absl::string_view> fields = absl::StrSplit(row, ',');
    Sighting sighting;
    int number = 0;
    if (fields.size() < 9 || !absl::SimpleAtoi(fields[0], &sighting.frame) ||
        !absl::SimpleAtod(fields[1], &sighting.time_seconds) ||
        !absl::SimpleAtoi(fields[2], &number) || !absl::SimpleAtod(fields[7], &sighting.area) ||
        !absl::SimpleAtod(fields[8], &sighting.probability)) {
      continue;
    }
    by_number[number].number = number;
    by_number[number].sightings.push_back(sighting);
  }
  std::vector<MoverTrack> movers;
  for (auto& [number, mover] : by_number) movers.push_back(std::move(mover));
  std::ranges::stable_sort(movers, std::greater<>(),
                           [](const MoverTrack& mover) { return mover.sightings.size(); });
  return movers;
}

}  // namespace egosieve::tools
