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
  // The same by source: links end in nodes of the flow grid, row by row; matches are of the frames'
  // features, those that went into `labelled`.
  std::vector<PointPair> links;
  std::vector<uint8_t> link_is_textured;
  std::vector<Match> matches;
  int64_t feature_count = 0;  // features and textured grid points of the second frame
  int64_t match_count = 0;    // of these, those found again in the other frame
  SceneAgreement scene;
  // Features of the second frame, whenever they were computed, and dense flow; then, search among
  // descriptors and the checks of matches and flow.
  double features_milliseconds = 0.0, matching_milliseconds = 0.0;
};

// Frames of one size, `pictures` apart. Features are looked for where the flow between the frames
// leads, where it does not hold where the motion before leads (empty: not known), and else, or
// where that finds little, everywhere. Errors are those of the libraries beneath.
absl::StatusOr<FramePairs> BuildPairs(const ExtractedFrame& first, const ExtractedFrame& second,
                                      const MotionField& motion, int pictures,
                                      const FrameLabellerOptions& options, FlowCache& flows);

FlowGridOptions GridOptionsOf(const FrameLabellerOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_PAIR_BUILDER_H_
