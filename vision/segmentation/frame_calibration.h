// Fits the squashing to a frame's own labelled places rather than to the model's points.
//
// The model's points were thinned to lie apart. So each is harder to predict from its neighbours
// than a pixel is from the points around it, and leave-one-out is underconfident. The fit is that
// of probabilistic_least_squares.h, (LS2). It uses a sample of places that the model does not hold,
// half of them from each class, reweighted to the frame's share of movers (the mean of its labels).
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/model/posterior.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::vision {

// inputs: N x D; labels: N, in [0, 1]; left: rows to sample from, increasing, at least one. The fit
// starts from the posterior's squashing. Errors as Posterior::Evaluate's.
absl::StatusOr<gp::SquashParameters> FitSquashToFrame(const gp::Posterior& posterior,
                                                      kernels::ConstMatrixView<float> inputs,
                                                      absl::Span<const double> labels,
                                                      absl::Span<const int64_t> left,
                                                      int64_t sample_size, uint64_t seed);

}  // namespace egosieve::vision
