#include "vision/segmentation/selection.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::vision {
namespace {

using gp::LabelledPoints;
using gp::NoisyBlobs;
using gp::RowMatrix;
using gp::TestGenerator;
using gp::ViewOf;
using testing::ElementsAre;
using testing::IsEmpty;
// The definition, by brute force.
std::vector<int64_t> Definition(const RowMatrix& x, const std::vector<double>& labels,
                                double radius, const std::vector<int64_t>& order) {
  std::vector<int64_t> kept;
  for (const int64_t i : order) {
    const bool near = std::any_of(kept.begin(), kept.end(), [&](int64_t j) {
      return (labels[i] >= 0.5) == (labels[j] >= 0.5) &&
             (x.row(i) - x.row(j)).squaredNorm() < radius * radius;
    });
    if (!near) kept.push_back(i);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

TEST(DensityFilter, FollowsItsDefinition) {
  auto generator = TestGenerator();
  for (const int64_t n : {0, 1, 2, 50, 700}) {
    for (const double radius : {0.0, 0.08, 0.3, 10.0}) {
      const LabelledPoints points = NoisyBlobs(n, 3, generator);
      std::vector<int64_t> order(n);
      std::iota(order.begin(), order.end(), int64_t{0});
      const auto kept = FilterByDensity(ViewOf(points.inputs), points.labels, radius);
      EXPECT_EQ(kept, Definition(points.inputs, points.labels, radius, order));
      std::reverse(order.begin(), order.end());
      const auto newest = FilterByDensity(ViewOf(points.inputs), points.labels, radius, order);
      EXPECT_EQ(newest, Definition(points.inputs, points.labels, radius, order));
    }
  }
}

TEST(DensityFilter, DuplicatesOfEachSideLeaveOneEach) {
  const RowMatrix x = RowMatrix::Constant(1000, 6, 0.25);
  std::vector<double> labels(1000, 0.0);
  labels[600] = 0.5;  // counts as high
  const auto kept = FilterByDensity(ViewOf(x), labels, 1e-9);
  EXPECT_EQ(kept, (std::vector<int64_t>{0, 600}));
}

const std::vector<double> kLabels = {0.0, 0.4, 0.5, 1.0, 0.9, 0.2};
const std::vector<float> kPredictions = {0.1f, 0.55f, 0.5f, 0.3f, 1.2f, 0.45f};

TEST(AgreementFilter, NoveltyAndConsistencyPartThePoints) {
  EXPECT_THAT(FilterByAgreement(kLabels, kPredictions, false), ElementsAre(1, 3));
  EXPECT_THAT(FilterByAgreement(kLabels, kPredictions, true), ElementsAre(0, 2, 4, 5));
}

// With equal ranks.
BudgetDecision Enforce(const std::vector<double>& labels, const std::vector<int64_t>& births,
                       int64_t time, const BudgetOptions& options) {
  return EnforceBudget(labels, births, time, options, std::vector<double>(labels.size(), 0.0));
}

TEST(Budget, DropsTheOldest) {
  BudgetOptions options{.budget = 3, .rare_class_share = 0.0};
  const auto decision = Enforce({0.0, 1.0, 0.0, 1.0, 0.0}, {5, 2, 9, 2, 7}, 10, options);
  EXPECT_THAT(decision.dropped, ElementsAre(1, 3));
  EXPECT_EQ(decision.dropped_for_budget, 2);
  EXPECT_EQ(decision.dropped_for_age, 0);
  options.budget = 5;
  EXPECT_THAT(Enforce({0.0, 1.0, 0.0, 1.0, 0.0}, {5, 2, 9, 2, 7}, 10, options).dropped, IsEmpty());
}

TEST(Budget, RankBreaksTiesOfAge) {
  const BudgetOptions options{.budget = 2, .rare_class_share = 0.0};
  const std::vector<double> rank = {3.0, 1.0, 2.0};
  EXPECT_THAT(EnforceBudget({0.0, 0.0, 0.0}, {4, 4, 4}, 5, options, rank).dropped, ElementsAre(1));
  EXPECT_THAT(Enforce({0.0, 0.0, 0.0}, {4, 4, 4}, 5, options).dropped, ElementsAre(0));
}

TEST(Budget, ProtectsTheRareClass) {
  // 40 old dynamic points, then static ones without end.
  std::vector<double> labels(40, 1.0);
  labels.resize(400, 0.0);
  std::vector<int64_t> births(40, 0);
  births.resize(400, 50);
  const BudgetOptions options{.budget = 100, .rare_class_share = 0.25};
  const auto decision = Enforce(labels, births, 50, options);
  EXPECT_EQ(decision.dropped.size(), 300u);
  const auto rare_dropped = std::count_if(decision.dropped.begin(), decision.dropped.end(),
                                          [](int64_t i) { return i < 40; });
  EXPECT_EQ(rare_dropped, 15);  // 25 of 100 stay
}

TEST(Budget, StalePointsGoWhateverTheirClass) {
  const BudgetOptions options{.maximum_age = 10};
  const auto decision = Enforce({1.0, 0.0, 0.0}, {0, 89, 90}, 100, options);
  EXPECT_THAT(decision.dropped, ElementsAre(0, 1));
  EXPECT_EQ(decision.dropped_for_age, 2);
}

TEST(Budget, DynamicPointsGoSooner) {
  const auto decision =
      Enforce({1.0, 0.5, 0.49, 0.0, 0.9}, {9, 8, 8, 0, 10}, 10, {.maximum_positive_age = 1});
  EXPECT_THAT(decision.dropped, ElementsAre(1));
  EXPECT_EQ(decision.dropped_for_age, 1);
}

TEST(Budget, NothingIsKeptOrThere) {
  const BudgetOptions none{.budget = 0};
  EXPECT_THAT(Enforce({0.1, 0.9, 0.3}, {1, 2, 3}, 4, none).dropped, ElementsAre(0, 1, 2));
  EXPECT_THAT(Enforce({}, {}, 4, none).dropped, IsEmpty());
}

}  // namespace
}  // namespace egosieve::vision
