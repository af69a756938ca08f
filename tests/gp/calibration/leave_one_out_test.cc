#include "gp/calibration/leave_one_out.h"

#include <algorithm>
#include <vector>

#include "gp/model/exact_model.h"
#include "gtest/gtest.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

ExactModel Fit(const Hyperparameters& theta, const RowMatrix& x,
               const std::vector<double>& labels) {
  auto model = Value(ExactModel::Create(TestContext(), theta));
  EXPECT_TRUE(model.Add(ViewOf(x), labels, 0).ok());
  return model;
}

TEST(LeaveOneOut, EqualsExplicitRefits) {
  auto generator = TestGenerator();
  for (const int64_t n : {1, 2, 9, 65}) {
    const LabelledPoints points = NoisyBlobs(n, 4, generator);
    const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 4);
    const ExactModel model = Fit(theta, points.inputs, points.labels);
    const auto left_out = Value(model.PredictLeaveOneOut());
    for (int64_t i = 0; i < n; ++i) {
      RowMatrix rest(n - 1, 4);
      rest << points.inputs.topRows(i), points.inputs.bottomRows(n - 1 - i);
      std::vector<double> labels = points.labels;
      labels.erase(labels.begin() + i);
      const ExactModel without = Fit(theta, rest, labels);
      const RowMatrix query = points.inputs.row(i);
      const auto expected = Value(without.Predict(ViewOf(query), PredictWhat::kMeanAndVariance));
      EXPECT_NEAR(left_out.mean[i], expected.mean[0], 1e-10);
      EXPECT_NEAR(left_out.target_variance[i], expected.variance[0] + theta.noise_variance(),
                  1e-10);
      EXPECT_NEAR(left_out.LatentVariance(theta.noise_variance())[i], expected.variance[0], 1e-10);
    }
  }
}

TEST(LeaveOneOut, ASampleIsPartOfTheWhole) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(400, 6, generator);
  const ExactModel model =
      Fit(DefaultHyperparameters(CovarianceFunction::kArcsine, 6), points.inputs, points.labels);
  const auto whole = Value(model.PredictLeaveOneOut());
  const std::vector<int64_t> rows = RandomRows(400, 150, generator);
  const auto sample = Value(model.PredictLeaveOneOut(rows));
  EXPECT_EQ(sample.rows, rows);
  for (size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(sample.mean[i], whole.mean[rows[i]], 1e-11);
    EXPECT_NEAR(sample.target_variance[i], whole.target_variance[rows[i]], 1e-11);
  }
  EXPECT_THAT(model.PredictLeaveOneOut({3, 3}), IsInvalid());
  EXPECT_THAT(model.PredictLeaveOneOut({400}), IsInvalid());
  EXPECT_THAT(ComputeLeaveOneOut(model.factor(), {1.0}, {1.0}), IsInvalid());
}

TEST(StratifiedSample, KeepsTheRareClass) {
  std::vector<double> targets(1000, -1.0);
  for (int i = 0; i < 60; ++i) targets[i * 16] = 1.0;
  const auto count_high = [&](const std::vector<int64_t>& rows) {
    return std::count_if(rows.begin(), rows.end(), [&](int64_t i) { return targets[i] >= 0.0; });
  };
  const std::vector<int64_t> sample = StratifiedSample(targets, 200, 0.25, 1);
  EXPECT_EQ(sample.size(), 200u);
  EXPECT_TRUE(std::is_sorted(sample.begin(), sample.end()));
  EXPECT_EQ(std::adjacent_find(sample.begin(), sample.end()), sample.end());
  EXPECT_EQ(count_high(sample), 50);
  EXPECT_EQ(count_high(StratifiedSample(targets, 200, 0.0, 1)), 12);
  EXPECT_EQ(count_high(StratifiedSample(targets, 400, 0.5, 1)), 60);  // all there are
  EXPECT_EQ(sample, StratifiedSample(targets, 200, 0.25, 1));
  EXPECT_NE(sample, StratifiedSample(targets, 200, 0.25, 2));
  EXPECT_EQ(StratifiedSample(targets, 5000, 0.25, 1).size(), 1000u);
  EXPECT_TRUE(StratifiedSample(targets, 0, 0.25, 1).empty());
  EXPECT_TRUE(StratifiedSample({}, 10, 0.25, 1).empty());
  for (double& target : targets) target = -1.0;
  EXPECT_EQ(StratifiedSample(targets, 200, 0.25, 1).size(), 200u);
}

}  // namespace
}  // namespace egosieve::gp
