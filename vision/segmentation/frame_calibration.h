// Squashing fitted to a frame's own labelled places rather than to the model's points.
//
// The model's points were thinned to lie apart, so each is harder to tell from its neighbours than
// a pixel is from the points around it: leave-one-out is underconfident. What is fitted is
// probabilistic_least_squares.h, (LS2), at a sample of places that the model does not hold, half of
// them of each class, weighed back to the frame's share of movers (the mean of its labels).
#ifndef EGOSIEVE_VISION_SEGMENTATION_FRAME_CALIBRATION_H_
#define EGOSIEVE_VISION_SEGMENTATION_FRAME_CALIBRATION_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/model/posterior.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::vision {

// inputs: N x D; labels: N, in [0, 1]; left: rows to sample from, increasing, at least one. Starts
// from the posterior's squashing. Errors as Posterior::Evaluate's.
absl::StatusOr<gp::SquashParameters> FitSquashToFrame(const gp::Posterior& posterior,
                                                      kernels::ConstMatrixView<float> inputs,
                                                      absl::Span<const double> labels,
                                                      absl::Span<const int64_t> left,
                                                      int64_t sample_size, uint64_t seed,
                                                      const gp::SquashFitOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_FRAME_CALIBRATION_H_
