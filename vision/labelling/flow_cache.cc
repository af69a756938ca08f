#include "vision/labelling/flow_cache.h"

#include <limits>
#include <utility>

#include "vision/features/flow_growth.h"

namespace egosieve::vision {

absl::StatusOr<std::shared_ptr<const FlowPair>> FlowCache::Between(const ExtractedFrame& first,
                                                                   const ExtractedFrame& second) {
  std::shared_ptr<Entry> entry;
  {
    std::lock_guard lock(mutex_);
    std::shared_ptr<Entry>& known = flows_[{first.frame.index, second.frame.index}];
    if (known == nullptr) known = std::make_shared<Entry>();
    entry = known;
  }
  std::call_once(entry->once, [&] {
    absl::StatusOr<FlowPair> flow = ComputeFlow(first.grey, second.grey, options_.quality);
    if (flow.ok()) {
      if (options_.searches_lost) GrowFlow(first.grey, second.grey, options_, *flow);
      entry->flow = std::make_shared<const FlowPair>(*std::move(flow));
    } else {
      entry->flow = flow.status();
    }
  });
  return entry->flow;
}

void FlowCache::Forget(int64_t index) {
  std::lock_guard lock(mutex_);
  flows_.erase(flows_.begin(), flows_.lower_bound({index, std::numeric_limits<int64_t>::min()}));
}

}  // namespace egosieve::vision
