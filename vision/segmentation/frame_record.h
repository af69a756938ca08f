// The record of one frame: counts of points, state of the model, times. One line of frames.jsonl.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "vision/evidence/fusion.h"
#include "vision/labelling/labelled_frame.h"

namespace egosieve::vision {

// Numbers of points after the four filters (paper, section IV-E) and the budget.
struct SelectionCounts {
  int64_t candidates = 0;  // labelled features of the frame
  int64_t dropped_by_density = 0;
  int64_t dropped_by_novelty = 0;
  int64_t added = 0;
  int64_t dropped_by_consistency = 0;  // of the model's points, as in the fields below
  int64_t dropped_by_model_density = 0;
  int64_t dropped_by_age = 0;
  int64_t dropped_by_budget = 0;
};

struct FrameRecord : LabelSummary {
  double time_seconds = 0.0;
  int64_t static_label_count = 0;   // p < 1/2
  int64_t dynamic_label_count = 0;  // p >= 1/2
  int frame_gap = 0;                // between the two frames of the pair; 0: no pair
  std::array<int64_t, kEvidenceTerms> decided_count{};  // of the dynamic labels, by EvidenceTerm

  SelectionCounts selection;
  int64_t model_size = 0;
  std::vector<double> theta;            // log scales..., log sigma_f, log sigma_n
  double log_likelihood_per_point = 0;  // log p(y | X) / n of the model; 0 where it is empty
  bool factor_rebuilt = false;
  double jitter = 0.0;
  double squash_a = 1.0;
  double squash_b = 0.0;

  double dynamic_share = 0.0;  // of the grid, probability >= 1/2
  double expected_overlap = std::numeric_limits<double>::quiet_NaN();  // (EO1), (EO2); NaN: no map
  int64_t clamped_variances = 0;
  bool learnt = false;
};

}  // namespace egosieve::vision
