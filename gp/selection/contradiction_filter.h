// Drops points of the model that newer points contradict.
//
//   A point is dropped if the nearest of the newer points is closer than r and has its label on
//   the other side of 1/2.                                                                 (CF1)
//
// Where the class of an input changes with time, old points contradict the new labels. The
// comparison is with the newer labels, not with the model's prediction (consistency,
// agreement_filter.h), which lags behind them. Cost: m log n for m points against n newer ones.
#ifndef EGOSIEVE_GP_SELECTION_CONTRADICTION_FILTER_H_
#define EGOSIEVE_GP_SELECTION_CONTRADICTION_FILTER_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

// inputs: m x D, labels: m; newer_inputs: n x D, newer_labels: n; labels in [0, 1]. Returns the
// kept rows of `inputs`, increasing: all of them for radius 0. InvalidArgument for NaN, wrong sizes
// or a negative radius.
absl::StatusOr<std::vector<int64_t>> FilterByContradiction(
    kernels::ConstMatrixView<double> inputs, absl::Span<const double> labels,
    kernels::ConstMatrixView<float> newer_inputs, absl::Span<const double> newer_labels,
    double radius);

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_SELECTION_CONTRADICTION_FILTER_H_
