#include "gp/selection/budget.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Budget, DropsTheOldest) {
  BudgetOptions options;
  options.budget = 3;
  options.rare_class_share = 0.0;
  const auto decision =
      Value(EnforceBudget({0.0, 1.0, 0.0, 1.0, 0.0}, {5, 2, 9, 2, 7}, 10, options));
  EXPECT_THAT(decision.dropped, ElementsAre(1, 3));
  EXPECT_EQ(decision.dropped_for_budget, 2);
  EXPECT_EQ(decision.dropped_for_age, 0);
  options.budget = 5;
  EXPECT_THAT(EnforceBudget({0.0, 1.0, 0.0, 1.0, 0.0}, {5, 2, 9, 2, 7}, 10, options)->dropped,
              IsEmpty());
}

TEST(Budget, RankBreaksTiesOfAge) {
  BudgetOptions options;
  options.budget = 2;
  options.rare_class_share = 0.0;
  const std::vector<double> rank = {3.0, 1.0, 2.0};
  EXPECT_THAT(EnforceBudget({0.0, 0.0, 0.0}, {4, 4, 4}, 5, options, rank)->dropped, ElementsAre(1));
  EXPECT_THAT(EnforceBudget({0.0, 0.0, 0.0}, {4, 4, 4}, 5, options)->dropped, ElementsAre(0));
}

TEST(Budget, ProtectsTheRareClass) {
  // 40 old dynamic points, then static ones without end.
  std::vector<double> labels(40, 1.0);
  labels.resize(400, 0.0);
  std::vector<int64_t> births(40, 0);
  births.resize(400, 50);
  BudgetOptions options;
  options.budget = 100;
  options.rare_class_share = 0.25;
  const auto decision = Value(EnforceBudget(labels, births, 50, options));
  EXPECT_EQ(decision.dropped.size(), 300u);
  const auto rare_dropped = std::count_if(decision.dropped.begin(), decision.dropped.end(),
                                          [](int64_t i) { return i < 40; });
  EXPECT_EQ(rare_dropped, 15);  // 25 of 100 stay
}

TEST(Budget, StalePointsGoWhateverTheirClass) {
  BudgetOptions options;
  options.maximum_age = 10;
  const auto decision = Value(EnforceBudget({1.0, 0.0, 0.0}, {0, 89, 90}, 100, options));
  EXPECT_THAT(decision.dropped, ElementsAre(0, 1));
  EXPECT_EQ(decision.dropped_for_age, 2);
}

TEST(Budget, DynamicPointsGoSooner) {
  BudgetOptions options;
  options.maximum_positive_age = 1;
  const auto decision =
      Value(EnforceBudget({1.0, 0.5, 0.49, 0.0, 0.9}, {9, 8, 8, 0, 10}, 10, options));
  EXPECT_THAT(decision.dropped, ElementsAre(1));
  EXPECT_EQ(decision.dropped_for_age, 1);
}

TEST(Budget, NothingAndNonsense) {
  BudgetOptions options;
  options.budget = 0;
  EXPECT_THAT(EnforceBudget({0.1, 0.9, 0.3}, {1, 2, 3}, 4, options)->dropped, ElementsAre(0, 1, 2));
  EXPECT_THAT(EnforceBudget({}, {}, 4, options)->dropped, IsEmpty());
  EXPECT_THAT(EnforceBudget({0.1}, {}, 4), IsInvalid());
  EXPECT_THAT(EnforceBudget({std::nan("")}, {1}, 4), IsInvalid());
  EXPECT_THAT(EnforceBudget({0.1}, {1}, 4, {}, {1.0, 2.0}), IsInvalid());
  options.budget = -1;
  EXPECT_THAT(EnforceBudget({0.1}, {1}, 4, options), IsInvalid());
  options = {};
  options.maximum_positive_age = -1;
  EXPECT_THAT(EnforceBudget({0.1}, {1}, 4, options), IsInvalid());
  options = {};
  options.rare_class_share = 0.6;
  EXPECT_THAT(EnforceBudget({0.1}, {1}, 4, options), IsInvalid());
}

}  // namespace
}  // namespace egosieve::gp
