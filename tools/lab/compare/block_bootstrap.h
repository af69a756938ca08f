// Confidence interval of a mean difference when neighbouring frames are alike: the block bootstrap.
//
//   d_i       the difference of two methods' figures in frame i
//   blocks    `block_frames` consecutive frames within one drive, wrapping at its end; shorter in a
//             drive with fewer than three such blocks, since a drive drawn whole never varies
//   resample  for each drive of n frames ceil(n / block_frames) blocks with replacement, cut to n
//   interval  quantiles 0.025 and 0.975 of the resampled means over all frames
//
// Confidence interval with respect to the choice of drives: the bootstrap over sequences.
//
//   d_s       a drive's mean difference; the figure is their mean, so long drives do not dominate
//   resample  as many drives with replacement; interval as above
//
// A figure's trend over time, with the same blocks as above:
//
//   slope      b = sum (t - T_d)(a - A_d) / sum (t - T_d)^2 over all frames of all drives d, whose
//              means are T_d and A_d: drives may have different levels
//   residuals  e = a - A_d - b (t - T_d)
//   resample   the residuals of each drive by blocks in a row, wrapping, around the fitted line;
//              the interval is that of the slopes fitted to the resampled data
//
// Deterministic in the seed. Reference: Künsch (1989); circular blocks after Politis and Romano
// (1992).
#ifndef EGOSIEVE_TOOLS_LAB_COMPARE_BLOCK_BOOTSTRAP_H_
#define EGOSIEVE_TOOLS_LAB_COMPARE_BLOCK_BOOTSTRAP_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"

namespace egosieve::tools {

struct BootstrapOptions {
  int block_frames = 10;  // at least 1
  int resamples = 2000;   // at least 40, so that the quantiles exist
  uint64_t seed = 1;

  absl::Status Validate() const;
};

struct BootstrapInterval {
  double mean = 0.0;
  double low = 0.0;
  double high = 0.0;
  double share_positive = 0.0;  // of the resampled means; those at 0 count half
  int64_t frames = 0;
};

// Takes each drive's differences in the order of its frames; drives without frames are left out.
// Absent if there are no frames. Options must be valid.
std::optional<BootstrapInterval> BlockBootstrap(const std::vector<std::vector<double>>& differences,
                                                const BootstrapOptions& options);

// Here `frames` is the number of drives. Absent if there are none. Options must be valid.
std::optional<BootstrapInterval> SequenceBootstrap(const std::vector<double>& differences,
                                                   const BootstrapOptions& options);

struct FrameFigure {
  double frame = 0.0;  // t
  double value = 0.0;  // a
};

// `mean` is the slope per frame. `frames` counts the frames of all drives used; drives with fewer
// than three frames are left out. Absent if no drive is left. Options must be valid.
std::optional<BootstrapInterval> SlopeBootstrap(const std::vector<std::vector<FrameFigure>>& drives,
                                                const BootstrapOptions& options);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_COMPARE_BLOCK_BOOTSTRAP_H_
