// Joint covariances, samples and several outputs, against the textbook's formulas by Eigen.
#include <cmath>
#include <vector>

#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

struct Problem {
  Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kSquaredExponential, 3);
  RowMatrix x, y, queries;
  std::vector<double> noise;  // v

  Problem(int64_t n, int64_t outputs, std::mt19937_64& generator)
      : x(RandomPoints(n, 3, generator)), y(n, outputs), queries(RandomPoints(40, 3, generator)) {
    for (int64_t i = 0; i < n; ++i) {
      for (int64_t c = 0; c < outputs; ++c) y(i, c) = std::sin((c + 1.0) * x(i, 0)) + x(i, 1);
      noise.push_back(0.2 * std::abs(x(i, 2)));
    }
  }
  ExactModel Model() const {
    auto model = Value(ExactModel::Create(TestContext(), theta));
    EXPECT_EQ(model.AddObservations({ViewOf(x), ViewOf(y)}, 0), absl::OkStatus());
    return model;
  }
  // Two backward stable solutions differ by at most about n eps cond(K) of the prior variance.
  double Tolerance() const {
    return 4.0 * x.rows() * 2.2e-16 * GramOf(theta, x).trace() / theta.noise_variance() * 1.7;
  }
};

TEST(JointPosterior, WithoutPointsIsThePrior) {
  auto generator = TestGenerator();
  const Problem problem(1, 1, generator);
  auto model = Value(ExactModel::Create(TestContext(), problem.theta));
  const auto joint = Value((*model.MakeFloat64Posterior())->PredictJoint(ViewOf(problem.queries)));
  const RowMatrix prior = Covariances(problem.theta, problem.queries, problem.queries);
  EXPECT_LE((CopyOf(joint.covariance.view()) - prior).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_THAT(joint.mean, testing::Each(0.0));
  const auto samples =
      Value((*model.MakeFloat64Posterior())->Sample(ViewOf(problem.queries), {.count = 2}));
  EXPECT_NE(samples.values.row(0)[0], samples.values.row(0)[1]);
}

TEST(JointPosterior, SamplesHaveItsMoments) {
  auto generator = TestGenerator();
  const Problem problem(60, 2, generator);
  const ExactModel model = problem.Model();
  const RowMatrix queries = problem.queries.topRows(4);
  const auto joint = Value((*model.MakeFloat64Posterior())->PredictJoint(ViewOf(queries)));
  SampleOptions options{.count = 20000};
  for (const bool of_observation : {false, true}) {
    options.of_observation = of_observation;
    const auto samples = Value((*model.MakeFloat64Posterior())->Sample(ViewOf(queries), options));
    ASSERT_EQ(samples.values.cols(), 2 * options.count);
    RowMatrix sigma = CopyOf(joint.covariance.view());
    if (of_observation) sigma.diagonal().array() += problem.theta.noise_variance();
    const RowMatrix values = CopyOf(samples.values.view());
    for (int64_t c = 0; c < 2; ++c) {
      const RowMatrix y = values.block(0, c * options.count, 4, options.count);
      for (int64_t i = 0; i < 4; ++i) {
        const double mean = y.row(i).mean();
        EXPECT_NEAR(mean, joint.mean[2 * i + c], 6.0 * std::sqrt(sigma(i, i) / options.count));
        const double variance = (y.row(i).array() - mean).square().mean();
        EXPECT_NEAR(variance, sigma(i, i), 6.0 * sigma(i, i) * std::sqrt(2.0 / options.count));
      }
    }
  }
}

TEST(SeveralOutputs, AreAsManyModelsWithOneFactor) {
  auto generator = TestGenerator();
  const Problem problem(120, 3, generator);
  ExactModel model = problem.Model();
  ASSERT_TRUE(model.Remove({0, 5, 6, 119}).ok());
  EXPECT_EQ(model.outputs(), 3);
  const auto all = Value(Predict(model, ViewOf(problem.queries), PredictWhat::kMeanAndVariance));
  const auto posterior = Value(model.MakePosterior({}));
  const NarrowMatrix queries = problem.queries.cast<float>();
  std::vector<float> means(40 * 3), variances(40);
  ASSERT_TRUE(
      posterior->Evaluate({queries.data(), 40, 3}, {means.data(), variances.data(), nullptr}).ok());
  const std::vector<double> own = model.PredictOwnMean();
  double likelihood = 0.0;
  for (int64_t c = 0; c < 3; ++c) {
    auto alone = ExactModel::Create(TestContext(), problem.theta);
    const std::vector<double> y(problem.y.col(c).begin(), problem.y.col(c).end());
    ASSERT_TRUE(alone->AddObservations({ViewOf(problem.x), y}, 0).ok());
    ASSERT_TRUE(alone->Remove({0, 5, 6, 119}).ok());
    const auto one = Value(Predict(*alone, ViewOf(problem.queries), PredictWhat::kMeanAndVariance));
    for (int64_t i = 0; i < 40; ++i) {
      EXPECT_NEAR(all.mean[3 * i + c], one.mean[i], problem.Tolerance());
      EXPECT_EQ(all.variance[i], one.variance[i]);
      // Queries are rounded to float32, and so are the results; slopes are below 10.
      EXPECT_NEAR(means[3 * i + c], one.mean[i], 20.0 * 6e-8);
      EXPECT_NEAR(variances[i], one.variance[i], 1e-4);
    }
    EXPECT_NEAR(own[3 * 7 + c], alone->PredictOwnMean()[7], problem.Tolerance());
    likelihood += alone->LogMarginalLikelihood();
  }
  EXPECT_NEAR(model.LogMarginalLikelihood(), likelihood, 1e-9 * std::abs(likelihood));
  const auto mean = Value(model.PredictMean({queries.data(), 40, 3}));
  EXPECT_EQ(mean, means);
}

TEST(SeveralOutputs, StayAsManyAsTheyAre) {
  auto generator = TestGenerator();
  const Problem problem(20, 2, generator);
  ExactModel model = problem.Model();
  const absl::Status status =
      model.AddObservations({ViewOf(RowMatrix(problem.x.topRows(1))), {1.0}}, 0);
  EXPECT_THAT(status, IsInvalid("1 outputs; the model's points have 2"));
  float probability = 0.0f;
  const float query[3] = {0.0f, 0.0f, 0.0f};
  const auto posterior = Value(model.MakePosterior({}));
  EXPECT_THAT(posterior->Evaluate({query, 1, 3}, {nullptr, nullptr, &probability}), IsInvalid());
  std::vector<int64_t> all(20);
  std::iota(all.begin(), all.end(), 0);
  ASSERT_TRUE(model.Remove(all).ok());
  EXPECT_TRUE(model.AddObservations({ViewOf(RowMatrix(problem.x.topRows(1))), {1.0}}, 0).ok());
  EXPECT_EQ(model.outputs(), 1);
}

// Gradients of mean and variance by the inputs, against finite differences.

constexpr int64_t kDimension = 3;

// By input d, with steps of 1e-4.
template <typename Model>
Prediction CentralDifferences(const Model& model, const RowMatrix& queries, int64_t d) {
  constexpr double kStep = 1e-4;
  RowMatrix ahead = queries, behind = queries;
  ahead.col(d).array() += kStep;
  behind.col(d).array() -= kStep;
  const auto right = Value(Predict(model, ViewOf(ahead), PredictWhat::kMeanAndVariance));
  const auto left = Value(Predict(model, ViewOf(behind), PredictWhat::kMeanAndVariance));
  Prediction slope = right;
  for (size_t i = 0; i < slope.mean.size(); ++i) {
    slope.mean[i] = (right.mean[i] - left.mean[i]) / (2.0 * kStep);
  }
  for (size_t i = 0; i < slope.variance.size(); ++i) {
    slope.variance[i] = (right.variance[i] - left.variance[i]) / (2.0 * kStep);
  }
  return slope;
}

template <typename Model>
void ExpectGradients(const Model& model, const RowMatrix& queries) {
  const int64_t k = model.outputs();
  const auto posterior = Value(model.MakeFloat64Posterior());
  const auto at =
      Value(posterior->PredictGradients(ViewOf(queries), PredictWhat::kMeanAndVariance));
  for (int64_t d = 0; d < kDimension; ++d) {
    const Prediction slope = CentralDifferences(model, queries, d);
    for (int64_t i = 0; i < queries.rows(); ++i) {
      // Central differences: h^2 / 6 times third derivatives of up to 1e2, and rounding 1e-12 / h.
      EXPECT_NEAR(at.variance[i * kDimension + d], slope.variance[i], 2e-6)
          << "query " << i << " input " << d;
      for (int64_t c = 0; c < k; ++c) {
        EXPECT_NEAR(at.mean[(i * k + c) * kDimension + d], slope.mean[i * k + c], 2e-6)
            << "query " << i << " input " << d;
      }
    }
  }
  const auto of_mean = Value(posterior->PredictGradients(ViewOf(queries), PredictWhat::kMean));
  EXPECT_EQ(of_mean.mean, at.mean);
  EXPECT_TRUE(of_mean.variance.empty());
}

class InputGradient : public testing::TestWithParam<MeanFunction> {};

TEST_P(InputGradient, EqualsFiniteDifferences) {
  auto generator = TestGenerator();
  for (const char* text : {"arcsine", "matern52 + linear", "isotropic(rational_quadratic)"}) {
    SCOPED_TRACE(text);
    Hyperparameters theta = DefaultHyperparameters(*CovarianceFunction::Parse(text), kDimension);
    theta.mean = GetParam();
    auto model = Value(ExactModel::Create(TestContext(), theta));
    const RowMatrix x = RandomPoints(70, kDimension, generator);
    RowMatrix y(70, 2);
    for (int64_t i = 0; i < 70; ++i) y.row(i) << std::sin(3.0 * x(i, 0)), x(i, 1) * x(i, 2);
    ASSERT_TRUE(model.AddObservations({ViewOf(x), ViewOf(y)}, 0).ok());
    RowMatrix queries = RandomPoints(9, kDimension, generator);
    queries.row(0) = x.row(0);
    ExpectGradients(model, queries);
  }
}

TEST(InputGradient, OfSparseModelsEqualsFiniteDifferences) {
  auto generator = TestGenerator();
  for (const SparseApproximation approximation :
       {SparseApproximation::kDtc, SparseApproximation::kFitc}) {
    auto model = Value(SparseModel::Create(
        TestContext(), DefaultHyperparameters(*CovarianceFunction::Parse("matern52"), kDimension),
        {.approximation = approximation, .inducing_points = 20}));
    const RowMatrix x = RandomPoints(70, kDimension, generator);
    RowMatrix y(70, 1);
    for (int64_t i = 0; i < 70; ++i) y(i, 0) = std::sin(3.0 * x(i, 0)) * x(i, 1);
    ASSERT_TRUE(model.AddObservations({ViewOf(x), ViewOf(y)}, 0).ok());
    const RowMatrix queries = RandomPoints(9, kDimension, generator);
    ExpectGradients(model, queries);
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
