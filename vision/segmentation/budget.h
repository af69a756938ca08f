// Enforces the limit on a model's size, with regard to age and the balance of the classes.
//
// Of n points, those older than `maximum_age` are dropped first, and those with a label of 1/2 or
// more that are older than `maximum_positive_age`, where positive labels hold for a shorter time.
// Of the remaining points n - budget are dropped, oldest first; but the rarer class is not reduced
// below
//
//   protected = min(its size, floor(rare_class_share * budget)),                         (BU1)
//
// so that ten points of one class for each of the other do not displace the other. `rank` breaks
// ties of age: the smaller is dropped first.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"

namespace egosieve::vision {

struct BudgetOptions {
  int64_t budget = 4000;           // points; 0 empties the model
  double rare_class_share = 0.25;  // of the budget, in [0, 0.5]
  // Of a point, the present time less its insertion time.
  int64_t maximum_age = std::numeric_limits<int64_t>::max();
  int64_t maximum_positive_age = std::numeric_limits<int64_t>::max();

  absl::Status Validate() const;
};

struct BudgetDecision {
  std::vector<int64_t> dropped;  // rows, increasing
  int64_t dropped_for_age = 0;
  int64_t dropped_for_budget = 0;
};

// labels: N in [0, 1]; insertion_times: N; time: the present; rank: N values that break ties of
// age; empty: the order of the rows.
absl::StatusOr<BudgetDecision> EnforceBudget(absl::Span<const double> labels,
                                             absl::Span<const int64_t> insertion_times,
                                             int64_t time, const BudgetOptions& options = {},
                                             absl::Span<const double> rank = {});

}  // namespace egosieve::vision
