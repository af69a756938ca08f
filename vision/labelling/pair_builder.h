// Correspondences between two frames, from features and from flow.
#ifndef EGOSIEVE_VISION_LABELLING_PAIR_BUILDER_H_
#define EGOSIEVE_VISION_LABELLING_PAIR_BUILDER_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/geometry/point_pair.h"
#include "vision/labelling/extracted_frame.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/matching/feature_matcher.h"
#include "vision/matching/motion_field.h"

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
  // The same by source, for the flow's grid and for features; of these only those found again that
  // move as their neighbours do.
  int64_t textured_count = 0, flow_count = 0;
  int64_t described_count = 0, agreeing_count = 0;
  // Features of the second frame, whenever they were computed, and dense flow; then, search among
  // descriptors and the checks of matches and flow.
  double features_milliseconds = 0.0, matching_milliseconds = 0.0;
};

// Whether the two frames show one scene. Chance agrees, too: flow between unrelated pictures, the
// smoother the better, at up to 0.17 of the texture, and matches, of which chance makes 0.01 to
// 0.07 of the features, with their neighbours at 0.002. Frames that follow each other, at speed in
// a narrow street, had 0.43 and 0.15 at least. One of the two suffices: smooth pictures have few
// features, and flow is lost where things move far.
bool ShowOneScene(const FramePairs& pairs);

// Frames of one size, `pictures` apart. Features are looked for where the flow between the frames
// leads, where it does not hold where the motion before leads (empty: not known), and else, or
// where that finds little, everywhere. Errors are those of the libraries beneath.
absl::StatusOr<FramePairs> BuildPairs(const ExtractedFrame& first, const ExtractedFrame& second,
                                      const MotionField& motion, int pictures,
                                      const FrameLabellerOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_PAIR_BUILDER_H_
