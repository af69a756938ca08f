// The state that a labeller carries from frame to frame, as bytes.
//
//   magic, version | frame gap | ground's speed | places that moved | motions of pairs |
//   evidence_labeller.h: pictures, grid tracks, sums of evidence, poses, own vehicle |
//   focal_learner.h, where there is one
//
// Numbers are little-endian as in memory. Each count precedes its items. Equal states give equal
// bytes. About 3 MB at 1242 x 375.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "vision/labelling/evidence_labeller.h"
#include "vision/labelling/focal_learner.h"
#include "vision/labelling/gap_choice.h"
#include "vision/labelling/mover_memory.h"
#include "vision/labelling/pair_motions.h"
#include "vision/trajectory/ground_speed.h"

namespace egosieve::vision {

struct LabellerState {
  GapState gap;
  GroundSpeed::State ground = GroundSpeed().state();
  MovedNodes moved;
  std::vector<KnownMotion> motions;
  EvidenceLabellerState evidence;
  std::optional<FocalLearnerState> focal;
};

std::string ToBytes(const LabellerState& state);
// InvalidArgument for bytes that ToBytes of this version did not write.
absl::StatusOr<LabellerState> FromBytes(absl::string_view bytes);

}  // namespace egosieve::vision
