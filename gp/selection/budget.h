// The hard limit on a model's size, aware of age and of the balance of the classes.
//
// Of n points, those older than `maximum_age_frames` go first, and those whose label is 1/2 or more
// and that are older than `maximum_dynamic_age_frames`: what moves is no longer where it was. Of
// the rest, n - budget go, oldest first; but the rarer class is not cut below
//
//   protected = min(its size, floor(rare_class_share * budget)),                         (BU1)
//
// so that ten static points for each dynamic one do not push the dynamic ones out. Ties of age
// are broken by `rank`: the smaller goes first.
#ifndef EGOSIEVE_GP_SELECTION_BUDGET_H_
#define EGOSIEVE_GP_SELECTION_BUDGET_H_

#include <cstdint>
#include <limits>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"

namespace egosieve::gp {

struct BudgetOptions {
  int64_t budget = 4000;           // points; 0 empties the model
  double rare_class_share = 0.25;  // of the budget, in [0, 0.5]
  int64_t maximum_age_frames = std::numeric_limits<int64_t>::max();
  int64_t maximum_dynamic_age_frames = std::numeric_limits<int64_t>::max();

  absl::Status Validate() const;
};

struct BudgetDecision {
  std::vector<int64_t> dropped;  // rows, increasing
  int64_t dropped_for_age = 0;
  int64_t dropped_for_budget = 0;
};

// labels: N in [0, 1]; birth_frames: N; frame: the present one; rank: N values that break ties of
// age, or empty for the rows' order.
absl::StatusOr<BudgetDecision> EnforceBudget(absl::Span<const double> labels,
                                             absl::Span<const int64_t> birth_frames, int64_t frame,
                                             const BudgetOptions& options = {},
                                             absl::Span<const double> rank = {});

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_SELECTION_BUDGET_H_
