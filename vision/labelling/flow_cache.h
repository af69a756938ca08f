// Flows between the pictures of frames, each computed once, whichever thread wants it first.
#ifndef EGOSIEVE_VISION_LABELLING_FLOW_CACHE_H_
#define EGOSIEVE_VISION_LABELLING_FLOW_CACHE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "absl/status/statusor.h"
#include "vision/features/flow_grid.h"
#include "vision/labelling/extracted_frame.h"

namespace egosieve::vision {

class FlowCache {
 public:
  explicit FlowCache(const FlowGridOptions& options) : options_(options) {}

  // Computes the flow, unless it is known, or waits for the thread that computes it. Thread-safe.
  absl::StatusOr<std::shared_ptr<const FlowPair>> Between(const ExtractedFrame& first,
                                                          const ExtractedFrame& second);
  // Drops the flows that begin before the frame `index`. Thread-safe.
  void Forget(int64_t index);

 private:
  struct Entry {
    std::once_flag once;
    absl::StatusOr<std::shared_ptr<const FlowPair>> flow = absl::UnknownError("not computed");
  };

  const FlowGridOptions options_;
  std::mutex mutex_;                                                     // of flows_
  std::map<std::pair<int64_t, int64_t>, std::shared_ptr<Entry>> flows_;  // by the frames' indices
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_FLOW_CACHE_H_
