#include "vision/labelling/flow_cache.h"

#include <limits>
#include <utility>

#include "kernels/base/status_macros.h"
#include "vision/features/flow_growth.h"

namespace egosieve::vision {

std::shared_ptr<FlowCache::Entry> FlowCache::EntryOf(const ExtractedFrame& first,
                                                     const ExtractedFrame& second) {
  std::lock_guard lock(mutex_);
  std::shared_ptr<Entry>& entry = entries_[{first.frame.index, second.frame.index}];
  if (entry == nullptr) entry = std::make_shared<Entry>();
  return entry;
}

const absl::StatusOr<std::shared_ptr<const FlowPair>>& FlowCache::FlowOf(
    Entry& entry, const ExtractedFrame& first, const ExtractedFrame& second) const {
  std::call_once(entry.once, [&] {
    absl::StatusOr<FlowPair> flow = ComputeFlow(first.grey, second.grey, options_.quality);
    if (flow.ok()) {
      if (options_.searches_lost) GrowFlow(first.grey, second.grey, options_, *flow);
      entry.flow = std::make_shared<const FlowPair>(*std::move(flow));
    } else {
      entry.flow = flow.status();
    }
  });
  return entry.flow;
}

absl::StatusOr<std::shared_ptr<const FlowPair>> FlowCache::Between(const ExtractedFrame& first,
                                                                   const ExtractedFrame& second) {
  return FlowOf(*EntryOf(first, second), first, second);
}

absl::StatusOr<std::shared_ptr<const TrackedGrid>> FlowCache::Grid(const ExtractedFrame& first,
                                                                   const ExtractedFrame& second,
                                                                   bool anchor_second) {
  const std::shared_ptr<Entry> entry = EntryOf(first, second);
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const FlowPair> flow,
                            FlowOf(*entry, first, second));
  std::shared_ptr<const TrackedGrid>& grid = entry->grids[anchor_second];
  std::call_once(entry->grid_once[anchor_second], [&] {
    grid = std::make_shared<const TrackedGrid>(
        TrackGrid(*flow, first.grey, second.grey, anchor_second, options_));
  });
  return grid;
}

void FlowCache::Forget(int64_t index) {
  std::lock_guard lock(mutex_);
  entries_.erase(entries_.begin(),
                 entries_.lower_bound({index, std::numeric_limits<int64_t>::min()}));
}

}  // namespace egosieve::vision
