// Correspondences between two frames, from features and from flow.
#ifndef EGOSIEVE_VISION_LABELLING_PAIR_BUILDER_H_
#define EGOSIEVE_VISION_LABELLING_PAIR_BUILDER_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/point_pair.h"
#include "vision/labelling/extracted_frame.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/labelling/pair_motions.h"
#include "vision/matching/feature_matcher.h"
#include "vision/matching/motion_field.h"
#include "vision/matching/scene_agreement.h"

namespace egosieve::vision {

struct FramePairs {
  std::vector<PointPair> labelled;  // to be given labels
  std::vector<PointPair> geometry;  // to estimate the motion from
  // The same by source: links end in nodes of the flow grid, row by row; matches are between the
  // frames' features, only those in `labelled`.
  std::vector<PointPair> links;
  std::vector<uint8_t> link_is_textured;
  std::vector<Match> matches;
  int64_t feature_count = 0;  // features and textured grid points of the second frame
  int64_t match_count = 0;    // of these, the ones with a match in the other frame
  SceneAgreement scene;
  // First: dense flow and the features of the second frame, also if they were computed earlier.
  // Second: search among descriptors and the checks of matches and flow.
  double features_milliseconds = 0.0, matching_milliseconds = 0.0;
};

// The frames have one size and are `pictures` apart. Features are searched for at the places
// predicted by the flow between the frames; if the flow fails, by `motion` of the pair before
// (empty: not known). Without a prediction, or if few are found, they are searched for everywhere.
// Errors are those of the called functions.
absl::StatusOr<FramePairs> BuildPairs(const ExtractedFrame& first, const ExtractedFrame& second,
                                      const MotionField& motion, int pictures,
                                      const FrameLabellerOptions& options, FlowCache& flows);

FlowGridOptions GridOptionsOf(const FrameLabellerOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_PAIR_BUILDER_H_
