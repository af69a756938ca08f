#include "gp/selection/agreement_filter.h"

#include <cmath>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using testing::ElementsAre;

const std::vector<double> kLabels = {0.0, 0.4, 0.5, 1.0, 0.9, 0.2};
const std::vector<float> kPredictions = {0.1f, 0.55f, 0.5f, 0.3f, 1.2f, 0.45f};

TEST(AgreementFilter, NoveltyAndConsistencyPartThePoints) {
  EXPECT_THAT(*FilterByNovelty(kLabels, kPredictions), ElementsAre(1, 3));
  EXPECT_THAT(*FilterByConsistency(kLabels, kPredictions), ElementsAre(0, 2, 4, 5));
}

TEST(AgreementFilter, UndecidedPointsPassBoth) {
  const AgreementOptions options{0.2};  // predictions within 0.1 of a half
  EXPECT_THAT(*FilterByNovelty(kLabels, kPredictions, options), ElementsAre(1, 2, 3, 5));
  EXPECT_THAT(*FilterByConsistency(kLabels, kPredictions, options), ElementsAre(0, 1, 2, 4, 5));
}

TEST(AgreementFilter, NothingAndNonsense) {
  EXPECT_THAT(*FilterByNovelty({}, {}), ElementsAre());
  EXPECT_THAT(FilterByNovelty({0.5}, {}), IsInvalid());
  EXPECT_THAT(FilterByNovelty({1.5}, {0.5f}), IsInvalid());
  EXPECT_THAT(FilterByConsistency({std::nan("")}, {0.5f}), IsInvalid());
  EXPECT_THAT(FilterByConsistency({0.5}, {std::nanf("")}), IsInvalid());
  EXPECT_THAT(FilterByConsistency({0.5}, {0.5f}, {-1.0}), IsInvalid());
}

}  // namespace
}  // namespace egosieve::gp
