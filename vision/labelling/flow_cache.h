// Flows between the pictures of frames and the grids they track, each computed once, whichever
// thread wants it first.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "absl/status/statusor.h"
#include "vision/features/flow_grid.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {

class FlowCache {
 public:
  explicit FlowCache(const FlowGridOptions& options) : options_(options) {}

  // Computes the flow, unless it is known, or waits for the thread that computes it. Thread-safe.
  absl::StatusOr<std::shared_ptr<const FlowPair>> Between(const ExtractedFrame& first,
                                                          const ExtractedFrame& second);
  // The grid of the second frame or of the first (TrackGrid) by that flow, likewise.
  absl::StatusOr<std::shared_ptr<const TrackedGrid>> Grid(const ExtractedFrame& first,
                                                          const ExtractedFrame& second,
                                                          bool anchor_second);
  // Drops what begins before the frame `index`. Thread-safe.
  void Forget(int64_t index);

 private:
  struct Entry {
    std::once_flag once;
    absl::StatusOr<std::shared_ptr<const FlowPair>> flow = absl::UnknownError("not computed");
    std::array<std::once_flag, 2> grid_once;  // by anchor_second
    std::array<std::shared_ptr<const TrackedGrid>, 2> grids;
  };

  std::shared_ptr<Entry> EntryOf(const ExtractedFrame& first, const ExtractedFrame& second);
  const absl::StatusOr<std::shared_ptr<const FlowPair>>& FlowOf(Entry& entry,
                                                                const ExtractedFrame& first,
                                                                const ExtractedFrame& second) const;

  const FlowGridOptions options_;
  std::mutex mutex_;                                                       // of entries_
  std::map<std::pair<int64_t, int64_t>, std::shared_ptr<Entry>> entries_;  // by the frames' indices
};

}  // namespace egosieve::vision
