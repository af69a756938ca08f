// Noise variances of their own for points: in the factor, through additions and removals, in
// leave-one-out, in sparse models and in the likelihood.
#include <Eigen/Cholesky>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "gp/training/hyperparameter_trainer.h"
#include "gp/training/marginal_likelihood.h"
#include "gtest/gtest.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;
using testing::HasSubstr;

struct NoisyPoints {
  RowMatrix x;
  std::vector<double> y, noise;
  Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 4);

  NoisyPoints(int64_t n, std::mt19937_64& generator) : x(RandomPoints(n, 4, generator)) {
    for (int64_t i = 0; i < n; ++i) {
      y.push_back(std::sin(3.0 * x(i, 0)) - x(i, 1));
      noise.push_back(0.5 * (1.0 + x(i, 2)));
    }
  }
  Observations Between(int64_t begin, int64_t end, bool with_noise = true) const {
    const kernels::ConstMatrixView<double> all = ViewOf(x);
    const size_t count = end - begin;
    return {
        all.rows_between(begin, end), absl::MakeConstSpan(y).subspan(begin, count),
        with_noise ? absl::MakeConstSpan(noise).subspan(begin, count) : absl::Span<const double>()};
  }
  RowMatrix Gram() const {
    RowMatrix k = GramOf(theta, x);
    for (int64_t i = 0; i < x.rows(); ++i) k(i, i) += noise[i];
    return k;
  }
  ExactModel Model() const {
    auto model = Value(ExactModel::Create(TestContext(), theta));
    EXPECT_TRUE(model.AddObservations(Between(0, x.rows()), 0).ok());
    return model;
  }
};

// alpha = K_y^-1 y within n eps cond(K_y), cond <= trace / least noise.
void ExpectAlpha(const NoisyPoints& points, const ExactModel& model) {
  const RowMatrix k = points.Gram();
  const Eigen::Map<const Eigen::VectorXd> y(points.y.data(), k.rows());
  const Eigen::VectorXd expected = Eigen::LLT<Eigen::MatrixXd>(k).solve(y);
  ASSERT_EQ(model.size(), k.rows());
  const double tolerance = 4.0 * k.rows() * 2.2e-16 * k.trace() / points.theta.noise_variance();
  for (int64_t i = 0; i < k.rows(); ++i) {
    EXPECT_NEAR(model.alpha()[i], expected[i], tolerance * expected.cwiseAbs().maxCoeff());
  }
}

TEST(NoiseByPoint, StandsOnTheDiagonal) {
  auto generator = TestGenerator();
  NoisyPoints points(90, generator);
  for (int64_t i = 0; i < 30; ++i) points.noise[i] = 0.0;
  auto model = Value(ExactModel::Create(TestContext(), points.theta));
  // The first points come without noise of their own.
  ASSERT_TRUE(model.AddObservations(points.Between(0, 30, false), 0).ok());
  ASSERT_TRUE(model.AddObservations(points.Between(30, 90), 1).ok());
  ExpectAlpha(points, model);
  const std::vector<int64_t> rows = {1, 35, 36, 89};
  ASSERT_TRUE(model.Remove(rows).ok());
  NoisyPoints left = points;
  left.x = RowMatrix(86, 4);
  EraseRows(1, rows, left.y);
  EraseRows(1, rows, left.noise);
  for (int64_t i = 0, at = 0; i < 90; ++i) {
    if (std::find(rows.begin(), rows.end(), i) == rows.end()) left.x.row(at++) = points.x.row(i);
  }
  ExpectAlpha(left, model);
  ASSERT_TRUE(model.Refactorize().ok());
  ExpectAlpha(left, model);
  const std::vector<double> own = model.PredictOwnMean();
  const auto there = Value(model.Predict(ViewOf(left.x), PredictWhat::kMean));
  for (int64_t i = 0; i < 86; ++i) EXPECT_NEAR(own[i], there.mean[i], 1e-11);
}

TEST(NoiseByPoint, LeavesPointsOut) {
  auto generator = TestGenerator();
  const NoisyPoints points(40, generator);
  const ExactModel model = points.Model();
  const auto left_out = Value(model.PredictLeaveOneOut());
  const std::vector<double> latent = left_out.LatentVariance(points.theta.noise_variance());
  for (const int64_t i : {0, 17, 39}) {
    ExactModel without = points.Model();
    ASSERT_TRUE(without.Remove({i}).ok());
    const RowMatrix query = points.x.row(i);
    const auto expected = Value(without.Predict(ViewOf(query), PredictWhat::kMeanAndVariance));
    EXPECT_NEAR(left_out.mean[i], expected.mean[0], 1e-10);
    EXPECT_NEAR(latent[i], expected.variance[0], 1e-10);
  }
}

TEST(NoiseByPoint, LikelihoodAndItsGradient) {
  auto generator = TestGenerator();
  const NoisyPoints points(70, generator);
  const ExactModel model = points.Model();
  const auto at = Value(ComputeMarginalLikelihood(
      *TestContext(), points.theta, points.Between(0, 70), LikelihoodOrder::kValueAndGradient));
  EXPECT_NEAR(at.value, model.LogMarginalLikelihood(), 1e-10);
  const std::vector<double> theta = ToLogarithms(points.theta);
  for (size_t t = 0; t < theta.size(); ++t) {
    const auto value = [&](double step) {
      std::vector<double> moved = theta;
      moved[t] += step;
      return Value(ComputeMarginalLikelihood(*TestContext(), *FromLogarithms(points.theta, moved),
                                             points.Between(0, 70), LikelihoodOrder::kValue))
          .value;
    };
    // Rounding 1e-13 / h.
    EXPECT_NEAR(at.gradient[t], FivePointSlope(value, 1e-4), 1e-6) << "theta_" << t;
  }
}

TEST(NoiseByPoint, ReachesTheTrainer) {
  auto generator = TestGenerator();
  const NoisyPoints points(80, generator);
  TrainerOptions options;
  options.annealing_evaluations = 5;
  options.initial_gradient_steps = 10;
  const auto trained = [&](absl::Span<const double> noise) {
    auto trainer = Value(HyperparameterTrainer::Create(
        points.theta, HyperparameterBounds::Default(CovarianceFunction::kArcsine, 4), options));
    EXPECT_TRUE(trainer.Train(*TestContext(), ViewOf(points.x), points.y, noise).ok());
    return ToLogarithms(trainer.hyperparameters());
  };
  const std::vector<double> zeros(80, 0.0);
  EXPECT_EQ(trained(zeros), trained({}));
  EXPECT_NE(trained(points.noise), trained({}));
  auto trainer = HyperparameterTrainer::Create(
      points.theta, HyperparameterBounds::Default(CovarianceFunction::kArcsine, 4), options);
  EXPECT_THAT(trainer->Train(*TestContext(), ViewOf(points.x), points.y, {1.0}), IsInvalid());
}

// With all points inducing, DTC and FITC are exact.
TEST(NoiseByPoint, IsInSparseModels) {
  auto generator = TestGenerator();
  const NoisyPoints points(60, generator);
  const ExactModel exact = points.Model();
  const auto expected = exact.Predict(ViewOf(points.x), PredictWhat::kMeanAndVariance);
  for (const auto kind : {SparseApproximation::kDtc, SparseApproximation::kFitc}) {
    SparseModelOptions options;
    options.approximation = kind;
    options.relative_jitter = 1e-9;
    options.refresh_share = 10.0;
    auto model = Value(SparseModel::Create(TestContext(), points.theta, options));
    ASSERT_TRUE(model.AddObservations(points.Between(0, 40), 0).ok());
    ASSERT_TRUE(model.SetInducingInputs(ViewOf(points.x)).ok());
    ASSERT_TRUE(model.AddObservations(points.Between(40, 60), 1).ok());
    const auto found = Value(model.Predict(ViewOf(points.x), PredictWhat::kMeanAndVariance));
    for (int64_t i = 0; i < 60; ++i) {
      // K_uu's jitter against its smallest pivots.
      EXPECT_NEAR(found.mean[i], expected->mean[i], 1e-6);
      EXPECT_NEAR(found.variance[i], expected->variance[i], 1e-6);
    }
    EXPECT_NEAR(model.LogMarginalLikelihood(), exact.LogMarginalLikelihood(), 1e-5);
  }
}

TEST(NoiseByPoint, RefusesWhatIsNoVariance) {
  auto generator = TestGenerator();
  NoisyPoints points(5, generator);
  auto model = ExactModel::Create(TestContext(), points.theta);
  for (const auto& [value, text] :
       {std::pair(-0.1, "-0.1"), std::pair(HUGE_VAL, "inf"), std::pair(std::nan(""), "nan")}) {
    points.noise[3] = value;
    EXPECT_THAT(model->AddObservations(points.Between(0, 5), 0),
                IsInvalid(absl::StrCat("noise_variances[3] = ", text)));
  }
  const std::vector<double> two = {0.1, 0.1};
  EXPECT_THAT(std::string(model->AddObservations({ViewOf(points.x), points.y, two}, 0).message()),
              HasSubstr("5 inputs and 2 noise variances"));
  EXPECT_EQ(model->size(), 0);
}

}  // namespace
}  // namespace egosieve::gp
