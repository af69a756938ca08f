// Reads tracks.csv (tools/refine/frame_products.h).
#pragma once

#include <cstdint>
#include <vector>

#include "absl/strings/string_view.h"

namespace egosieve::tools {

// A mover in a frame.
struct Sighting {
  int64_t frame = 0;
  double time_seconds = 0.0;
  double area = 0.0;         // pixels
  double probability = 0.0;  // mean of the pixels
};

struct MoverTrack {
  int number = 0;
  std::vector<Sighting> sightings;  // at least one, in the order of the rows
};

// tracks: the text of tracks.csv; rows that are no rows of it are left out. Those seen in most
// frames first, of equal ones that of the lower number.
std::vector<MoverTrack> ReadMoverTracks(absl::string_view tracks);

}  // namespace egosieve::tools
