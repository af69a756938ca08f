#include "vision/segmentation/budget.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "absl/strings/str_format.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {

absl::Status BudgetOptions::Validate() const {
  return kernels::CheckOptions({
      {"budget", budget, budget >= 0, "not be negative"},
      {"rare_class_share", rare_class_share, rare_class_share >= 0.0 && rare_class_share <= 0.5,
       "be in [0, 0.5]"},
      {"maximum_age", maximum_age, maximum_age >= 0, "not be negative"},
      {"maximum_positive_age", maximum_positive_age, maximum_positive_age >= 0, "not be negative"},
  });
}

absl::StatusOr<BudgetDecision> EnforceBudget(absl::Span<const double> labels,
                                             absl::Span<const int64_t> insertion_times,
                                             int64_t time, const BudgetOptions& options,
                                             absl::Span<const double> rank) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (labels.size() != insertion_times.size() || (!rank.empty() && rank.size() != labels.size())) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d labels, %d insertion times and %d ranks; the sizes must be equal",
                        labels.size(), insertion_times.size(), rank.size()));
  }
  BudgetDecision decision;
  std::vector<int64_t> left;
  int64_t class_sizes[2] = {0, 0};
  for (int64_t i = 0; i < static_cast<int64_t>(labels.size()); ++i) {
    if (!(labels[i] >= 0.0 && labels[i] <= 1.0) || (!rank.empty() && std::isnan(rank[i]))) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "point %d: label %g; labels must be in [0, 1] and ranks numbers", i, labels[i]));
    }
    const int64_t age = time - insertion_times[i];
    const bool is_positive = labels[i] >= 0.5;
    if (age > options.maximum_age || (is_positive && age > options.maximum_positive_age)) {
      decision.dropped.push_back(i);
      ++decision.dropped_for_age;
    } else {
      left.push_back(i);
      ++class_sizes[is_positive ? 1 : 0];
    }
  }
  int64_t excess = static_cast<int64_t>(left.size()) - options.budget;
  if (excess > 0) {
    const int rare = class_sizes[1] < class_sizes[0] ? 1 : 0;
    const int64_t share =
        static_cast<int64_t>(std::floor(options.rare_class_share * options.budget));
    int64_t droppable[2] = {class_sizes[0], class_sizes[1]};
    droppable[rare] -= std::min(class_sizes[rare], share);  // (BU1)
    std::sort(left.begin(), left.end(), [&](int64_t i, int64_t j) {
      return std::make_tuple(insertion_times[i], rank.empty() ? 0.0 : rank[i], i) <
             std::make_tuple(insertion_times[j], rank.empty() ? 0.0 : rank[j], j);
    });
    for (const int64_t i : left) {
      const int side = labels[i] >= 0.5 ? 1 : 0;
      if (excess == 0) break;
      if (droppable[side] == 0) continue;
      --droppable[side];
      --excess;
      decision.dropped.push_back(i);
      ++decision.dropped_for_budget;
    }
  }
  std::sort(decision.dropped.begin(), decision.dropped.end());
  return decision;
}

}  // namespace egosieve::vision
