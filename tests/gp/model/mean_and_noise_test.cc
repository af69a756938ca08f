// Mean functions whose coefficients have no prior: against Rasmussen & Williams' formulas (2.7) by
// Eigen, and what they make of leave-one-out, likelihood and device.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "gp/training/hyperparameter_trainer.h"
#include "gp/training/marginal_likelihood.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;
using testing::HasSubstr;

constexpr int64_t kDimension = 3;

class MeanFunctionTest : public testing::TestWithParam<MeanFunction> {
 protected:
  MeanFunctionTest() {
    auto generator = TestGenerator();
    theta_.mean = GetParam();
    x_ = RandomPoints(80, kDimension, generator);
    y_ = RowMatrix(80, 2);
    for (int64_t i = 0; i < 80; ++i) {
      y_(i, 0) = 40.0 + 7.0 * x_(i, 0) + std::sin(4.0 * x_(i, 1));
      y_(i, 1) = -5.0 + x_(i, 2) * x_(i, 2);
      noise_.push_back(0.5 * (1.0 + x_(i, 2)));
    }
    queries_ = 2.0 * RandomPoints(12, kDimension, generator);
  }

  RowMatrix Basis(const RowMatrix& x) const {
    const int64_t q = CoefficientCount(GetParam(), kDimension);
    RowMatrix h = RowMatrix::Ones(x.rows(), q);
    if (q > 1) h.rightCols(kDimension) = x;
    return h;
  }
  RowMatrix Gram() const {
    RowMatrix gram = GramOf(theta_, x_);
    for (int64_t i = 0; i < x_.rows(); ++i) gram(i, i) += noise_[i];
    return gram;
  }
  ExactModel Model(const RowMatrix& x, const RowMatrix& y) const {
    auto model = Value(ExactModel::Create(TestContext(), theta_));
    EXPECT_EQ(model.AddObservations({ViewOf(x), ViewOf(y), noise_}, 0), absl::OkStatus());
    return model;
  }

  Hyperparameters theta_ =
      UnevenHyperparameters(CovarianceFunction::kSquaredExponential, kDimension);
  RowMatrix x_, y_, queries_;
  std::vector<double> noise_;  // of each point, on top
};

TEST_P(MeanFunctionTest, IsTheTextbooks) {
  const ExactModel model = Model(x_, y_);
  const RowMatrix gram = Gram();
  const Eigen::MatrixXd inverse = gram.inverse();
  const RowMatrix h = Basis(x_), h_star = Basis(queries_);
  const RowMatrix k_star = Covariances(theta_, queries_, x_);
  // Eqs. 2.41 and 2.42 with B^-1 = 0, b = 0.
  const Eigen::MatrixXd information = (h.transpose() * inverse * h).inverse();
  const Eigen::MatrixXd beta = information * h.transpose() * inverse * y_;
  const RowMatrix mean = h_star * beta + k_star * inverse * (y_ - h * beta);
  const RowMatrix r = h_star - k_star * inverse * h;
  const RowMatrix covariance = Covariances(theta_, queries_, queries_) -
                               k_star * inverse * k_star.transpose() +
                               r * information * r.transpose();
  // n eps cond(K) of targets up to 50 and variances up to 50.
  const double tolerance = 80 * 2.2e-16 * gram.trace() / theta_.noise_variance() * 50.0;
  const auto joint = Value((*model.MakeFloat64Posterior())->PredictJoint(ViewOf(queries_)));
  const RowMatrix found = CopyOf(joint.covariance.view());
  EXPECT_LE((found - covariance).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_EQ(found, RowMatrix(found.transpose()));
  const auto marginal = Value(Predict(model, ViewOf(queries_), PredictWhat::kMeanAndVariance));
  for (int64_t i = 0; i < queries_.rows(); ++i) {
    EXPECT_NEAR(marginal.variance[i], covariance(i, i), tolerance);
    for (int64_t c = 0; c < 2; ++c) {
      EXPECT_NEAR(joint.mean[2 * i + c], mean(i, c), tolerance);
      EXPECT_EQ(joint.mean[2 * i + c], marginal.mean[2 * i + c]);
    }
  }
  const std::vector<double> own = model.PredictOwnMean();
  const auto at_own = Predict(model, ViewOf(x_), PredictWhat::kMean);
  for (size_t i = 0; i < own.size(); ++i) EXPECT_NEAR(own[i], at_own->mean[i], tolerance);
}

TEST_P(MeanFunctionTest, IsTheSameOnTheDevice) {
  const ExactModel model = Model(x_, y_.leftCols(1));
  const auto expected = Predict(model, ViewOf(queries_), PredictWhat::kMeanAndVariance);
  const auto posterior = Value(model.MakePosterior({0.1, -4.0}));
  const NarrowMatrix queries = queries_.cast<float>();
  const int64_t m = queries.rows();
  std::vector<float> mean(m), variance(m), probability(m);
  ASSERT_TRUE(posterior
                  ->Evaluate({queries.data(), m, kDimension},
                             {mean.data(), variance.data(), probability.data()})
                  .ok());
  double weight = 0.0;
  for (const double alpha : model.alpha()) weight += std::abs(alpha);
  for (int64_t i = 0; i < m; ++i) {
    // Covariances to 1e-6 sigma_f^2 each, and float32's rounding of numbers up to 60.
    EXPECT_NEAR(mean[i], expected->mean[i], 1.7e-6 * weight + 60.0 * 1.2e-7);
    EXPECT_NEAR(variance[i], expected->variance[i], 1e-4 + 1e-6 * expected->variance[i]);
    EXPECT_NEAR(probability[i], SquashParameters({0.1, -4.0}).Probability(mean[i], variance[i]),
                1e-6);
  }
}

// More than are made in float64 at a time.
TEST_P(MeanFunctionTest, AQueryGivesTheSameAmongMany) {
  const auto posterior = Value(Model(x_, y_).MakePosterior({}));
  const int64_t few = queries_.rows(), many = 20000;
  NarrowMatrix queries(many, kDimension);
  for (int64_t i = 0; i < many; ++i) queries.row(i) = queries_.row(i % few).cast<float>();
  std::vector<float> mean(2 * many), variance(many);
  ASSERT_TRUE(
      posterior->Evaluate({queries.data(), many, kDimension}, {mean.data(), variance.data()}).ok());
  for (int64_t i = few; i < many; ++i) {
    ASSERT_EQ(mean[2 * i], mean[2 * (i % few)]) << i;
    ASSERT_EQ(mean[2 * i + 1], mean[2 * (i % few) + 1]) << i;
    ASSERT_EQ(variance[i], variance[i % few]) << i;
  }
}

TEST_P(MeanFunctionTest, LeavesPointsOut) {
  const ExactModel model = Model(x_, y_);
  const auto left_out = Value(model.PredictLeaveOneOut());
  const std::vector<double> densities = left_out.LogDensities(model.targets());
  const std::vector<double> latent = left_out.LatentVariance(theta_.noise_variance());
  for (const int64_t i : {0, 41, 79}) {
    ExactModel without = Model(x_, y_);
    ASSERT_TRUE(without.Remove({i}).ok());
    const RowMatrix query = x_.row(i);
    const auto expected = Value(Predict(without, ViewOf(query), PredictWhat::kMeanAndVariance));
    const double variance = expected.variance[0] + theta_.noise_variance() + noise_[i];
    EXPECT_NEAR(left_out.target_variance[i], variance, 1e-9);
    EXPECT_NEAR(latent[i], expected.variance[0], 1e-9);
    for (int64_t c = 0; c < 2; ++c) {
      EXPECT_NEAR(left_out.mean[2 * i + c], expected.mean[c], 1e-8);
      const double error = y_(i, c) - expected.mean[c];
      EXPECT_NEAR(densities[2 * i + c],
                  -0.5 * (std::log(2.0 * M_PI * variance) + error * error / variance), 1e-7);
    }
  }
}

TEST_P(MeanFunctionTest, LikelihoodIsTheRestrictedOne) {
  const ExactModel model = Model(x_, y_);
  const auto at = Value(ComputeMarginalLikelihood(*TestContext(), theta_, model.observations(),
                                                  LikelihoodOrder::kValueAndGradient));
  EXPECT_NEAR(at.value, model.LogMarginalLikelihood(), 1e-9 * std::abs(at.value));
  // Eq. 2.45, of each output.
  const RowMatrix gram = Gram();
  const RowMatrix h = Basis(x_);
  const Eigen::MatrixXd inverse = gram.inverse();
  const Eigen::MatrixXd a = h.transpose() * inverse * h;
  const Eigen::MatrixXd p = inverse - inverse * h * a.inverse() * h.transpose() * inverse;
  const double n = 80.0 - h.cols();
  const double determinants =
      2.0 * Eigen::LLT<Eigen::MatrixXd>(gram).matrixLLT().diagonal().array().log().sum() +
      (h.cols() > 0 ? std::log(a.determinant()) : 0.0);
  const double expected =
      -0.5 * (y_.transpose() * p * y_).trace() - determinants - n * std::log(2.0 * M_PI);
  EXPECT_NEAR(at.value, expected, 1e-8 * std::abs(expected));
  const std::vector<double> logarithms = ToLogarithms(theta_);
  for (size_t t = 0; t < logarithms.size(); ++t) {
    const auto value = [&](double step) {
      std::vector<double> moved = logarithms;
      moved[t] += step;
      return Value(ComputeMarginalLikelihood(*TestContext(), *FromLogarithms(theta_, moved),
                                             model.observations(), LikelihoodOrder::kValue))
          .value;
    };
    // Truncation far below, and rounding eps cond / h of the value.
    EXPECT_NEAR(at.gradient[t], FivePointSlope(value, 1e-4), 1e-7 * std::abs(expected))
        << "theta_" << t;
  }
}

INSTANTIATE_TEST_SUITE_P(ZeroConstantLinear, MeanFunctionTest,
                         testing::Values(MeanFunction::kZero, MeanFunction::kConstant,
                                         MeanFunction::kLinear));

TEST(MeanFunction, NeedsPointsThatDetermineIt) {
  Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 2);
  theta.mean = MeanFunction::kLinear;
  auto model = Value(ExactModel::Create(TestContext(), theta));
  const double query[2] = {0.0, 0.0};
  const auto predicted = [&] { return Predict(model, {query, 1, 2}, PredictWhat::kMean).status(); };
  EXPECT_EQ(predicted().code(), absl::StatusCode::kFailedPrecondition);
  const double on_a_line[6] = {0.0, 0.0, 1.0, 1.0, 2.0, 2.0};
  ASSERT_TRUE(model.AddObservations({{on_a_line, 3, 2}, {1.0, 2.0, 3.0}}, 0).ok());
  EXPECT_THAT(predicted().message(), HasSubstr("3 points do not determine the 3 coefficients"));
  EXPECT_EQ(model.MakePosterior({}).status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(std::isnan(model.LogMarginalLikelihood()));
  const double beside_it[2] = {1.0, -1.0};
  ASSERT_TRUE(model.AddObservations({{beside_it, 1, 2}, {0.5}}, 0).ok());
  EXPECT_TRUE(predicted().ok()) << predicted();
  // Without the last point the others lie on the line again.
  EXPECT_EQ(model.PredictLeaveOneOut({3}).status().code(), absl::StatusCode::kFailedPrecondition);
}

// Noise variances of their own for points: in the factor, through additions and removals, in
// leave-one-out, in sparse models and in the likelihood.

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
  const auto there = Value(Predict(model, ViewOf(left.x), PredictWhat::kMean));
  for (int64_t i = 0; i < 86; ++i) EXPECT_NEAR(own[i], there.mean[i], 1e-11);
}

TEST(NoiseByPoint, ReachesTheTrainer) {
  auto generator = TestGenerator();
  const NoisyPoints points(80, generator);
  const TrainerOptions options{.annealing_evaluations = 5, .initial_gradient_steps = 10};
  const auto trained = [&](absl::Span<const double> noise) {
    auto trainer = Value(HyperparameterTrainer::Create(
        points.theta, HyperparameterBounds::Default(CovarianceFunction::kArcsine, 4), options));
    EXPECT_TRUE(trainer.Train(*TestContext(), {ViewOf(points.x), points.y, noise}).ok());
    return ToLogarithms(trainer.hyperparameters());
  };
  const std::vector<double> zeros(80, 0.0);
  EXPECT_EQ(trained(zeros), trained({}));
  EXPECT_NE(trained(points.noise), trained({}));
  auto trainer = HyperparameterTrainer::Create(
      points.theta, HyperparameterBounds::Default(CovarianceFunction::kArcsine, 4), options);
  const std::vector<double> one = {1.0};
  EXPECT_THAT(trainer->Train(*TestContext(), {ViewOf(points.x), points.y, one}), IsInvalid());
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
