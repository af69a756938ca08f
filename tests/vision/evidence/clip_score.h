// Evidence scored at labelled tracks: how well the probability tells movers from the rest.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/vision/evidence/labelled_clip.h"
#include "vision/evidence/evidence_accumulator.h"

namespace egosieve::vision {

// One a frame, from the clip's own features; identity and kNone for the first `gap` frames.
struct ClipMotion {
  MotionModelKind kind = MotionModelKind::kNone;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
};
absl::StatusOr<std::vector<ClipMotion>> FundamentalsOf(const LabelledClip& clip, int gap);

struct ClipScore {
  double auc = 0.5;                // of the probability, over all points of all frames
  double calibration_error = 0.0;  // expected, ten bins (ECE)
  int64_t moving = 0, resting = 0;
  double milliseconds = 0.0;  // a frame
};

// Labelled tracks take no part in estimating. Scored are the points that reach `gap` frames back.
absl::StatusOr<ClipScore> ScoreClip(const LabelledClip& clip,
                                    const std::vector<ClipMotion>& motions, int gap,
                                    const EvidenceOptions& options);

}  // namespace egosieve::vision
