// Which points the model takes, keeps and drops (paper, section IV-E, steps 1 to 4, and the budget),
// from plain arrays. Labels are in [0, 1]; rows are increasing.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::vision {

// Thins points that carry the same information (steps 1 and 4).
//
//   A point is dropped if an earlier kept point is closer than r and has its label on the same
//   side of 1/2.                                                                         (DEN1)
//
// Points are taken in the caller's order of preference, which decides which point of a cluster
// stays (for a model, for example, the newest). Every dropped point has a kept point of its side
// within r; kept points of one side are at least r apart. Neighbours come from a k-d tree: about
// n log n for moderate r.
//
// inputs: N x D, finite; labels: N; radius: r, in input space, 0 keeps everything; order: a
// permutation of 0..N-1, first is preferred; empty: the order of the rows. Returns the kept rows.
std::vector<int64_t> FilterByDensity(kernels::ConstMatrixView<double> inputs,
                                     absl::Span<const double> labels, double radius,
                                     absl::Span<const int64_t> order = {});

// Filters for novelty and consistency: does the model agree with the labels? (steps 2, 3)
//
//   agrees(i)  :=  (q_i >= 1/2) == (p_i >= 1/2)                                             (G1)
//
// p_i is the point's label and q_i the model's prediction: a probability, or (mean + 1) / 2.
// Novelty keeps new points that the model classifies wrongly (all of them for an empty model: the
// caller then has no q). Consistency keeps the model's points that it classifies correctly.
//
// Returns the rows of points that the model classifies correctly (`agreeing`) or wrongly.
std::vector<int64_t> FilterByAgreement(absl::Span<const double> labels,
                                       absl::Span<const float> predictions, bool agreeing);

// Enforces the limit on a model's size, with regard to age and the balance of the classes.
//
// Of n points, those older than `maximum_age` are dropped first, and those with a label of 1/2 or
// more that are older than `maximum_positive_age`, where positive labels hold for a shorter time.
// Of the remaining points n - budget are dropped, oldest first; but the rarer class is not reduced
// below
//
//   protected = min(its size, floor(rare_class_share * budget)),                         (BU1)
//
// so that ten points of one class for each of the other do not displace the other.
struct BudgetOptions {
  int64_t budget = 4000;           // points; 0 empties the model
  double rare_class_share = 0.25;  // of the budget, in [0, 0.5]
  // Of a point, the present time less its insertion time.
  int64_t maximum_age = std::numeric_limits<int64_t>::max();
  int64_t maximum_positive_age = std::numeric_limits<int64_t>::max();
};

struct BudgetDecision {
  std::vector<int64_t> dropped;  // rows
  int64_t dropped_for_age = 0;
  int64_t dropped_for_budget = 0;
};

// insertion_times: N; time: the present; rank: N, breaks ties of age, the smaller is dropped first.
BudgetDecision EnforceBudget(absl::Span<const double> labels,
                             absl::Span<const int64_t> insertion_times, int64_t time,
                             const BudgetOptions& options, absl::Span<const double> rank);

}  // namespace egosieve::vision
