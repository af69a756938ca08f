#include "vision/labelling/pair_builder.h"

#include "kernels/base/status_macros.h"
#include "vision/labelling/stopwatch.h"

namespace egosieve::vision {

FlowGridOptions GridOptionsOf(const FrameLabellerOptions& options) {
  FlowGridOptions grid;
  grid.stride_pixels = options.flow_stride_pixels;
  grid.quality = options.flow_quality;
  grid.searches_lost = options.searches_lost;
  grid.ignored = options.ignored;
  return grid;
}

absl::StatusOr<FramePairs> BuildPairs(const ExtractedFrame& first, const ExtractedFrame& second,
                                      FlowCache& flows) {
  FramePairs pairs;
  pairs.counts = PairCounts(second.grey.size());
  if (!IsLargeEnoughForFlow(second.grey.size())) return pairs;
  Stopwatch watch;
  EGOSIEVE_RETURN_IF_ERROR(flows.Between(first, second).status());
  pairs.features_milliseconds = watch.LapMilliseconds();
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const TrackedGrid> grid,
                            flows.Grid(first, second, /*anchor_second=*/true));
  pairs.links = grid->pairs;
  pairs.link_is_textured = grid->is_textured;
  pairs.counts.features = grid->textured_count;
  pairs.counts.matches = grid->agreeing_count;
  pairs.counts.labelled = static_cast<int64_t>(grid->pairs.size());
  for (size_t i = 0; i < grid->textured.size(); ++i) {
    pairs.counts.scene.AddFlow(grid->textured[i], grid->agrees[i] != 0);
  }
  pairs.matching_milliseconds = watch.LapMilliseconds();
  return pairs;
}

}  // namespace egosieve::vision
