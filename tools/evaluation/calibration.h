// Whether stated probabilities match frequencies. All measures come from the histograms of 16-bit
// scores (roc.h), where p_v = v / 65535 is the probability stated by score v:
//
//   Brier     sum_v ( p_v^+ (1 - p_v)^2 + p_v^- p_v^2 ) / n
//   log loss  -sum_v ( p_v^+ log p_v + p_v^- log (1 - p_v) ) / n,  p_v clipped to half a step from
//             0 and 1: a stated 0 may be any value that rounds to it
//   ECE       sum_b (n_b / n) |mean stated probability of bin b - share of positives in it|
//
// p_v^+, p_v^-: positives and negatives of score v; bins of equal width, the last one closed.
//
// References: Brier (1950); Guo et al., On Calibration of Modern Neural Networks (2017), eq. 3, for
// two classes.
#ifndef EGOSIEVE_TOOLS_EVALUATION_CALIBRATION_H_
#define EGOSIEVE_TOOLS_EVALUATION_CALIBRATION_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "tools/evaluation/roc.h"

namespace egosieve::tools {

struct ReliabilityBin {
  double low = 0.0;  // stated probabilities from here
  double high = 0.0;
  int64_t pixels = 0;
  double mean_stated = 0.0;     // of the bin's pixels; 0 if it has none
  double positive_share = 0.0;  // likewise
};

struct Calibration {
  double brier = 0.0;
  double log_loss = 0.0;
  double expected_calibration_error = 0.0;
  std::vector<ReliabilityBin> bins;
};

// Absent without pixels. `bins`: at least 1.
std::optional<Calibration> CalibrationOf(const RocHistogram& scores, int bins = 15);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_CALIBRATION_H_
