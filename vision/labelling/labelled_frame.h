// Output of the front end: places in a frame with their probabilities of belonging to a mover.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "kernels/base/matrix_view.h"
#include "vision/evidence/fusion.h"
#include "vision/frame/frame.h"
#include "vision/geometry/motion_model.h"
#include "vision/trajectory/camera_step.h"

namespace egosieve::vision {

enum class LabelOutcome {
  kLabelled,         // labels are given
  kNoPair,           // fewer than frame_gap + 1 frames seen so far, or since the last interruption
  kSizeChanged,      // the frame has another size than the ones before: labelling starts anew
  kTooFewFeatures,   // black, white or without texture
  kTooFewMatches,    // a cut, an obstructed lens, a turn by 90 degrees, ...
  kDuplicateFrame,   // the same picture again, byte for byte
  kUntrustedMotion,  // no motion model is supported by enough correspondences
};

struct StageMilliseconds {
  double equalization = 0.0;
  double features = 0.0;
  double matching = 0.0;
  double geometry = 0.0;
  double labelling = 0.0;
  double selection = 0.0;    // filters, their predictions, adding to and removing from the model
  double training = 0.0;     // hyperparameters, and rebuilding the factor
  double calibration = 0.0;  // leave-one-out, a and b
  double posterior = 0.0;    // making the dense posterior of the model
  double inference = 0.0;    // descriptors and posterior on the grid

  double total() const {
    return equalization + features + matching + geometry + labelling + selection + training +
           calibration + posterior + inference;
  }
};

// What the log, too, tells of a frame's labels; counts and times as far as they are known.
struct LabelSummary {
  int64_t frame_index = 0;    // the input frame
  std::string reason;         // why it has no labels, or was not learnt, in a sentence; else empty
  int64_t feature_count = 0;  // of the input frame: key points, corners, textured grid points
  int64_t match_count = 0;    // before any are discarded
  int64_t inlier_count = 0;   // of the motion model, among the matches it was estimated from
  MotionModelKind motion_model = MotionModelKind::kNone;
  double noise_pixels = 0.0;  // scale of static points' residuals, one standard deviation
  // Why the labels are not reliable: the camera's motion is unknown, or most of the image does not
  // agree with it. Empty: they are reliable.
  std::string doubt;
  CameraStep step;  // from the frame before; known where the motion is calibrated
  StageMilliseconds milliseconds;
};

// N labelled places; if outcome is not kLabelled, N = 0. The input frame is the later one of the
// pair.
struct LabelledFrame : LabelSummary {
  LabelOutcome outcome = LabelOutcome::kNoPair;
  int64_t first_index = -1, second_index = -1;  // the pair, -1 without one
  Frame labelled;                               // the frame whose pixels `positions` are in

  std::vector<double> positions;  // N x 2, (x, y) in pixels of `labelled`, inside it
  // N x 2, in the pair's other frame; the same as in `positions` if a place has none there.
  std::vector<double> other_positions;
  std::vector<double> probability;  // N, of being dynamic, in [0, 1]
  // N, the term that contributes most in the direction of the probability.
  std::vector<EvidenceTerm> decided_by;

  double parallax_pixels = 0.0;  // as in gap_choice.h; 0 where not measured
  int64_t discarded_count = 0;   // matches without a label
  double static_share = 1.0;     // of the places that a calibrated motion was estimated from

  int64_t size() const { return static_cast<int64_t>(probability.size()); }
  kernels::ConstMatrixView<double> positions_view() const {
    return kernels::ConstMatrixView<double>(positions.data(), size(), 2);
  }
};

}  // namespace egosieve::vision
