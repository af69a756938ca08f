// One scene point followed through consecutive frames. A track may have any length; its places in
// the last kTrackHistory frames are kept.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace egosieve::vision {

inline constexpr int kTrackHistory = 16;

struct Track {
  int64_t id = -1;         // unique within a drive
  int64_t parent_id = -1;  // id in the frame before, another track's after a split; -1: none
  int64_t length = 0;      // frames since its start, including the current one
  std::array<cv::Point2f, kTrackHistory> places;  // [k]: k frames before the current one, pixels

  // Whether places[k] exists.
  bool Reaches(int k) const { return k >= 0 && k < kTrackHistory && k < length; }

  // The track continued to `place` in the next frame.
  Track Continued(cv::Point2f place) const {
    Track next;
    next.id = id;
    next.parent_id = id;
    next.length = length + 1;
    next.places[0] = place;
    std::copy(places.begin(), places.end() - 1, next.places.begin() + 1);
    return next;
  }
};

// InvalidArgument for a track that no tracker makes. `state` names the tracks' owner.
inline absl::Status CheckTracks(const char* state, const std::vector<Track>& tracks,
                                int64_t next_id) {
  for (const Track& track : tracks) {
    if (track.id >= 0 && track.id < next_id && track.length >= 1) continue;
    return absl::InvalidArgumentError(absl::StrCat(state, " has a track ", track.id, " of length ",
                                                   track.length, "; the next id is ", next_id));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::vision
