// Options of evidence_accumulator.h: which terms of evidence are measured, and their weights.
#pragma once

#include "absl/status/status.h"
#include "vision/evidence/relative_pose.h"

namespace egosieve::vision {

struct EvidenceOptions {
  bool epipolar = true;  // distance to the motion model, of any kind
  bool negative_depth = true;
  bool road = true;
  bool accumulation = true;  // along tracks

  double focal_pixels = 0.0;        // 0: guessed (pinhole.h); the result hardly depends on it
  double forgetting = 0.5;          // lambda of (F3); [0, 1)
  double tempering = 0.7;           // kappa of (F4); (0, 1]
  double noise_memory = 0.9;        // of scales and the share of movers, per frame; [0, 1)
  double noise_floor_pixels = 0.1;  // of the scale of residuals; positive
  RelativePoseOptions pose;

  absl::Status Validate() const;
};

}  // namespace egosieve::vision
