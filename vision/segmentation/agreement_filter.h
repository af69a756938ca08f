// Filters for novelty and consistency: does the model agree with the labels? (paper, section IV-E,
// steps 2, 3)
//
//   agrees(i)  :=  (q_i >= 1/2) == (p_i >= 1/2)                                             (G1)
//
// p_i is the point's label and q_i the model's prediction: a probability, or (mean + 1) / 2.
// Novelty keeps new points that the model classifies wrongly (all of them for an empty model: the
// caller then has no q). Consistency keeps the model's points that it classifies correctly.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"

namespace egosieve::vision {

// Rows of points that the model classifies correctly (`agreeing`, step 3) or wrongly (step 2),
// increasing. InvalidArgument for other numbers than labels in [0, 1], and for NaN.
absl::StatusOr<std::vector<int64_t>> FilterByAgreement(absl::Span<const double> labels,
                                                       absl::Span<const float> predictions,
                                                       bool agreeing);

}  // namespace egosieve::vision
