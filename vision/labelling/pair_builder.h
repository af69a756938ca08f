// Correspondences between two frames, from flow.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/features/flow_grid.h"
#include "vision/geometry/point_pair.h"
#include "vision/labelling/extracted_frame.h"
#include "vision/labelling/flow_cache.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/label_outcome.h"

namespace egosieve::vision {

struct FramePairs {
  std::vector<PointPair> links;  // end in nodes of the flow grid, row by row
  std::vector<uint8_t> link_is_textured;
  PairCounts counts;
  // Dense flow; its checks.
  double features_milliseconds = 0.0, matching_milliseconds = 0.0;
};

// The frames have one size; without links if it is too small for flow.
absl::StatusOr<FramePairs> BuildPairs(const ExtractedFrame& first, const ExtractedFrame& second,
                                      FlowCache& flows);

FlowGridOptions GridOptionsOf(const FrameLabellerOptions& options);

}  // namespace egosieve::vision
