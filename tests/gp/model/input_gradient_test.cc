// Gradients of mean and variance by the inputs, against finite differences.
#include <cmath>
#include <vector>

#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "gtest/gtest.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

constexpr int64_t kDimension = 3;

// By input d, with steps of 1e-4.
template <typename Model>
Prediction CentralDifferences(const Model& model, const RowMatrix& queries, int64_t d) {
  constexpr double kStep = 1e-4;
  RowMatrix ahead = queries, behind = queries;
  ahead.col(d).array() += kStep;
  behind.col(d).array() -= kStep;
  const auto right = Value(model.Predict(ViewOf(ahead), PredictWhat::kMeanAndVariance));
  const auto left = Value(model.Predict(ViewOf(behind), PredictWhat::kMeanAndVariance));
  Prediction slope = right;
  for (size_t i = 0; i < slope.mean.size(); ++i) {
    slope.mean[i] = (right.mean[i] - left.mean[i]) / (2.0 * kStep);
  }
  for (size_t i = 0; i < slope.variance.size(); ++i) {
    slope.variance[i] = (right.variance[i] - left.variance[i]) / (2.0 * kStep);
  }
  return slope;
}

class InputGradient : public testing::TestWithParam<MeanFunction> {};

TEST_P(InputGradient, EqualsFiniteDifferences) {
  auto generator = TestGenerator();
  for (const char* text : {"arcsine", "matern52 + linear", "isotropic(rational_quadratic)"}) {
    Hyperparameters theta = DefaultHyperparameters(*CovarianceFunction::Parse(text), kDimension);
    theta.mean = GetParam();
    auto model = Value(ExactModel::Create(TestContext(), theta));
    const RowMatrix x = RandomPoints(70, kDimension, generator);
    RowMatrix y(70, 2);
    for (int64_t i = 0; i < 70; ++i) y.row(i) << std::sin(3.0 * x(i, 0)), x(i, 1) * x(i, 2);
    ASSERT_TRUE(model.AddObservations({ViewOf(x), ViewOf(y)}, 0).ok());
    RowMatrix queries = RandomPoints(9, kDimension, generator);
    queries.row(0) = x.row(0);
    const auto at = Value((*model.MakeFloat64Posterior())
                              ->PredictGradients(ViewOf(queries), PredictWhat::kMeanAndVariance));
    for (int64_t d = 0; d < kDimension; ++d) {
      const Prediction slope = CentralDifferences(model, queries, d);
      for (int64_t i = 0; i < queries.rows(); ++i) {
        // Central differences: h^2 / 6 times third derivatives of up to 1e2, and rounding 1e-12 /
        // h.
        EXPECT_NEAR(at.variance[i * kDimension + d], slope.variance[i], 2e-6)
            << text << " query " << i << " input " << d;
        for (int64_t c = 0; c < 2; ++c) {
          EXPECT_NEAR(at.mean[(i * 2 + c) * kDimension + d], slope.mean[2 * i + c], 2e-6)
              << text << " query " << i << " input " << d;
        }
      }
    }
    const auto of_mean = Value(
        (*model.MakeFloat64Posterior())->PredictGradients(ViewOf(queries), PredictWhat::kMean));
    EXPECT_EQ(of_mean.mean, at.mean);
    EXPECT_TRUE(of_mean.variance.empty());
  }
}

TEST(InputGradient, OfSparseModelsEqualsFiniteDifferences) {
  auto generator = TestGenerator();
  for (const SparseApproximation approximation :
       {SparseApproximation::kDtc, SparseApproximation::kFitc}) {
    SparseModelOptions options;
    options.approximation = approximation;
    options.inducing_points = 20;
    auto model = Value(SparseModel::Create(
        TestContext(), DefaultHyperparameters(*CovarianceFunction::Parse("matern52"), kDimension),
        options));
    const RowMatrix x = RandomPoints(70, kDimension, generator);
    RowMatrix y(70, 1);
    for (int64_t i = 0; i < 70; ++i) y(i, 0) = std::sin(3.0 * x(i, 0)) * x(i, 1);
    ASSERT_TRUE(model.AddObservations({ViewOf(x), ViewOf(y)}, 0).ok());
    const RowMatrix queries = RandomPoints(9, kDimension, generator);
    const auto at = Value((*model.MakeFloat64Posterior())
                              ->PredictGradients(ViewOf(queries), PredictWhat::kMeanAndVariance));
    for (int64_t d = 0; d < kDimension; ++d) {
      const Prediction slope = CentralDifferences(model, queries, d);
      for (int64_t i = 0; i < queries.rows(); ++i) {
        // As above.
        const int64_t entry = i * kDimension + d;
        EXPECT_NEAR(at.variance[entry], slope.variance[i], 2e-6);
        EXPECT_NEAR(at.mean[entry], slope.mean[i], 2e-6);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(MeanFunctions, InputGradient,
                         testing::Values(MeanFunction::kZero, MeanFunction::kConstant,
                                         MeanFunction::kLinear));

TEST(InputGradient, OfThePriorAndOfBadPoints) {
  const Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kSquaredExponential, 1);
  const auto model = ExactModel::Create(TestContext(), theta);
  const double query = 0.3, nan = std::nan("");
  const auto prior = Value((*model->MakeFloat64Posterior())
                               ->PredictGradients({&query, 1, 1}, PredictWhat::kMeanAndVariance));
  EXPECT_EQ(prior.mean, std::vector<double>{0.0});
  EXPECT_EQ(prior.variance, std::vector<double>{0.0});
  EXPECT_THAT((*model->MakeFloat64Posterior())->PredictGradients({&nan, 1, 1}, PredictWhat::kMean),
              IsInvalid());
}

}  // namespace
}  // namespace egosieve::gp
