// Thins points that carry the same information (paper, section IV-E, steps 1 and 4).
//
//   A point is dropped if an earlier kept point is closer than r and has its label on the same
//   side of 1/2.                                                                         (DEN1)
//
// Points are taken in the caller's order of preference, which decides which point of a cluster
// stays (for a model, for example, the newest). Every dropped point has a kept point of its side
// within r; kept points of one side are at least r apart. Neighbours come from a k-d tree: about
// n log n for moderate r.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::vision {

// inputs: N x D, double or float; labels: N, in [0, 1]; radius: r, in input space, 0 keeps
// everything; order: a permutation of 0..N-1, first is preferred; empty:
// the order of the rows. Returns the kept rows, increasing. InvalidArgument for NaN, wrong sizes or
// r < 0.
template <typename T>
absl::StatusOr<std::vector<int64_t>> FilterByDensity(kernels::ConstMatrixView<T> inputs,
                                                     absl::Span<const double> labels, double radius,
                                                     absl::Span<const int64_t> order = {});

}  // namespace egosieve::vision
