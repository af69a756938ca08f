#include "gp/model/exact_model.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "gp/covariance/hyperparameters.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;
using testing::ElementsAre;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

ExactModel MakeModel(const Hyperparameters& hyperparameters) {
  return Value(ExactModel::Create(TestContext(), hyperparameters));
}

void Add(const LabelledPoints& points, int64_t begin, int64_t end, int64_t time,
         ExactModel& model) {
  const kernels::ConstMatrixView<double> x = ViewOf(points.inputs);
  ASSERT_EQ(model.Add(x.rows_between(begin, end),
                      absl::MakeConstSpan(points.labels).subspan(begin, end - begin), time),
            absl::OkStatus());
}

// Everything that the model says follows from its points alone: compares with a plain solution.
void ExpectModelOf(const RowMatrix& x, const std::vector<double>& y, const ExactModel& model) {
  const int64_t n = x.rows();
  ASSERT_EQ(model.size(), n);
  const RowMatrix k = GramOf(model.hyperparameters(), x);
  const Eigen::Map<const Eigen::VectorXd> targets(y.data(), n);
  const Eigen::LLT<Eigen::MatrixXd> llt(k);
  const Eigen::VectorXd alpha = llt.solve(targets);
  // Two backward stable solutions differ by at most about n eps cond(K); cond <= trace / noise.
  const double relative = 4.0 * n * kEpsilon * k.trace() / model.hyperparameters().noise_variance();
  const Eigen::Map<const Eigen::VectorXd> found(model.alpha().data(), n);
  EXPECT_LE((found - alpha).norm(), relative * alpha.norm());
  EXPECT_LE(BackwardError(CopyOf(model.factor().Factor()), k, 2 * n + 100), 2.0);
}

TEST(ExactModel, FollowsAdditionsAndRemovals) {
  auto generator = TestGenerator();
  for (const auto function :
       {CovarianceFunction::kArcsine, CovarianceFunction::kSquaredExponential}) {
    const LabelledPoints points = NoisyBlobs(160, 6, generator);
    ExactModel model = MakeModel(UnevenHyperparameters(function, 6));
    Add(points, 0, 40, 3, model);
    Add(points, 40, 41, 4, model);
    Add(points, 41, 160, 9, model);
    ExpectModelOf(points.inputs, points.targets(), model);
    const std::vector<int64_t> rows = {0, 5, 39, 40, 77, 159};
    ASSERT_TRUE(model.Remove(rows).ok());
    const std::vector<int64_t> kept = Complement(160, rows);
    RowMatrix x(kept.size(), 6);
    std::vector<double> y;
    for (size_t i = 0; i < kept.size(); ++i) {
      x.row(i) = points.inputs.row(kept[i]);
      y.push_back(points.targets()[kept[i]]);
      EXPECT_EQ(model.points().identities[i], kept[i]);
      EXPECT_EQ(model.insertion_times()[i], kept[i] < 40 ? 3 : kept[i] < 41 ? 4 : 9);
    }
    EXPECT_EQ(CopyOf(model.inputs()), x);
    ExpectModelOf(x, y, model);
    // Nearly all go: the rebuild is cheaper and must give the same model.
    std::vector<int64_t> most(100);
    std::iota(most.begin(), most.end(), int64_t{10});
    ASSERT_TRUE(model.factor().RefactoringIsCheaper(most));
    ASSERT_TRUE(model.Remove(most).ok());
    RowMatrix rest(54, 6);
    rest << x.topRows(10), x.bottomRows(44);
    y.erase(y.begin() + 10, y.begin() + 110);
    ExpectModelOf(rest, y, model);
  }
}

TEST(ExactModel, TakesNewTargetsForItsPoints) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(60, 6, generator);
  ExactModel model = MakeModel(UnevenHyperparameters(CovarianceFunction::kArcsine, 6));
  Add(points, 0, 60, 1, model);
  std::vector<double> targets = points.targets();
  for (size_t i = 0; i < targets.size(); ++i) targets[i] = 0.5 * targets[i] - 0.01 * i;
  ASSERT_TRUE(model.SetTargets({targets.data(), 60, 1}).ok());
  EXPECT_EQ(std::vector<double>(model.targets().begin(), model.targets().end()), targets);
  ExpectModelOf(points.inputs, targets, model);
  const double likelihood = model.LogMarginalLikelihood();
  const std::vector<double> before(model.alpha().begin(), model.alpha().end());
  std::vector<double> wrong = targets;
  wrong[17] = std::nan("");
  for (const absl::Status& status :
       {model.SetTargets({wrong.data(), 60, 1}), model.SetTargets({targets.data(), 59, 1}),
        model.SetTargets({targets.data(), 30, 2})}) {
    EXPECT_THAT(status, IsInvalid());
  }
  EXPECT_EQ(std::vector<double>(model.alpha().begin(), model.alpha().end()), before);
  EXPECT_EQ(model.LogMarginalLikelihood(), likelihood);
}

TEST(ExactModel, PosteriorStaysAsTheModelWas) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(120, 6, generator);
  ExactModel model = MakeModel(DefaultHyperparameters(CovarianceFunction::kArcsine, 6));
  Add(points, 0, 100, 0, model);
  const SquashParameters squash{2.0, 0.1};
  const auto posterior = Value(model.MakePosterior(squash));
  const RowMatrix queries = RandomPoints(50, 6, generator).cast<float>().cast<double>();
  const auto expected = Predict(model, ViewOf(queries), PredictWhat::kMeanAndVariance);
  Add(points, 100, 120, 1, model);

  const NarrowMatrix narrow = queries.cast<float>();
  std::vector<float> mean(50), variance(50), probability(50);
  kernels::PosteriorOutputs outputs{mean.data(), variance.data(), probability.data()};
  ASSERT_TRUE(posterior->Evaluate({narrow.data(), 50, 6}, outputs).ok());
  for (int i = 0; i < 50; ++i) {
    // float32 throughout: 100 covariances of error 1e-6 each, weighted by |alpha| and |L^-1 k|.
    EXPECT_NEAR(mean[i], expected->mean[i], 1e-4);
    EXPECT_NEAR(variance[i], expected->variance[i], 1e-4);
    EXPECT_NEAR(probability[i], squash.Probability(expected->mean[i], expected->variance[i]), 1e-4);
  }
}

TEST(ExactModel, EmptyModelAnswersWithThePrior) {
  ExactModel model = MakeModel(DefaultHyperparameters(CovarianceFunction::kArcsine, 6));
  const RowMatrix queries = RowMatrix::Constant(3, 6, 0.25);
  const NarrowMatrix narrow = queries.cast<float>();
  const auto mean = Value(model.PredictMean({narrow.data(), 3, 6}));
  EXPECT_THAT(mean, ElementsAre(0.0f, 0.0f, 0.0f));
  const auto prediction = Value(Predict(model, ViewOf(queries), PredictWhat::kMeanAndVariance));
  EXPECT_EQ(prediction.mean[1], 0.0);
  EXPECT_EQ(prediction.variance[1],
            PriorVariance(model.hyperparameters().covariance, queries.row(1).data()));
  EXPECT_EQ(model.LogMarginalLikelihood(), 0.0);
  const auto posterior = Value(model.MakePosterior({1.0, 0.0}));
  float probability = 0.0f;
  const kernels::PosteriorOutputs outputs{.probability = &probability};
  const std::vector<float> query(6, 0.25f);
  ASSERT_TRUE(posterior->Evaluate({query.data(), 1, 6}, outputs).ok());
  EXPECT_EQ(probability, 0.5f);
  EXPECT_TRUE(model.Remove({}).ok());
  EXPECT_TRUE(model.Refactorize().ok());
  const auto left_out = Value(model.PredictLeaveOneOut());
  EXPECT_TRUE(left_out.mean.empty());
}

TEST(ExactModel, DuplicatesNeedNoJitterUnderNoise) {
  ExactModel model = MakeModel(DefaultHyperparameters(CovarianceFunction::kArcsine, 2));
  RowMatrix x = RowMatrix::Constant(300, 2, 0.3);
  for (int i = 0; i < 300; i += 3) x(i, 0) += 1e-13;  // near duplicates among exact ones
  std::vector<double> labels(300, 0.9);
  labels[7] = 0.1;
  ASSERT_TRUE(model.Add(ViewOf(x), labels, 0).ok());
  ASSERT_TRUE(model.Add(ViewOf(x), labels, 1).ok());
  EXPECT_EQ(model.jitter(), 0.0);
}

TEST(ExactModel, JitterClimbsWhereThereIsNoNoise) {
  Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 2);
  theta.noise_stddev = 1e-12;
  ExactModel model = MakeModel(theta);
  auto generator = TestGenerator();
  RowMatrix x = RandomPoints(20, 2, generator);
  x.row(19) = x.row(4);
  const std::vector<double> labels(20, 1.0);
  ASSERT_TRUE(model.Add(ViewOf(x), labels, 0).ok());
  EXPECT_GT(model.jitter(), 0.0);
  EXPECT_LE(model.jitter(), 1e-4);
  EXPECT_EQ(model.size(), 20);
  theta.noise_stddev = 0.3;
  ASSERT_TRUE(model.SetHyperparameters(theta).ok());
  EXPECT_EQ(model.jitter(), 0.0);
}

// At points of the data, far apart and with hardly any noise, variances are rounding.
TEST(ExactModel, CountsTheVariancesItClamps) {
  auto generator = TestGenerator();
  Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kSquaredExponential, 2);
  theta.covariance.scales.assign(2, 0.05);
  theta.noise_stddev = 1e-9;
  ExactModel model = MakeModel(theta);
  const LabelledPoints points = NoisyBlobs(200, 2, generator);
  Add(points, 0, 200, 0, model);
  const auto at = Value(Predict(model, ViewOf(points.inputs), PredictWhat::kMeanAndVariance));
  EXPECT_LE(at.clamped_variances, std::count(at.variance.begin(), at.variance.end(), 0.0));
  EXPECT_GT(at.clamped_variances, 0);
  const auto means = Predict(model, ViewOf(points.inputs), PredictWhat::kMean);
  EXPECT_EQ(means->clamped_variances, 0);
}

TEST(ExactModel, RefusesBadArgumentsAndStaysUnchanged) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(30, 3, generator);
  ExactModel model = MakeModel(DefaultHyperparameters(CovarianceFunction::kArcsine, 3));
  Add(points, 0, 30, 0, model);
  const RowMatrix factor = CopyOf(model.factor().Factor());
  const auto expect_invalid = [&](const absl::Status& status, const char* words) {
    EXPECT_THAT(status, IsInvalid(words));
    EXPECT_EQ(model.size(), 30);
    EXPECT_EQ(CopyOf(model.factor().Factor()), factor);
  };
  RowMatrix x = RowMatrix::Zero(2, 3);
  expect_invalid(model.Add(ViewOf(x), {0.5, 1.5}, 1), "labels[1] = 1.5");
  expect_invalid(model.Add(ViewOf(x), {0.5, std::nan("")}, 1), "labels[1] = nan");
  expect_invalid(model.Add(ViewOf(x), {0.5}, 1), "2 inputs");
  x(1, 2) = std::nan("");
  expect_invalid(model.Add(ViewOf(x), {0.5, 0.5}, 1), "inputs(1, 2)");
  const RowMatrix wide = RowMatrix::Zero(2, 4);
  expect_invalid(model.Add(ViewOf(wide), {0.5, 0.5}, 1), "4 columns");
  expect_invalid(model.Remove({3, 3}), "rows[1] = 3");
  expect_invalid(model.Remove({30}), "rows[0] = 30");
  Hyperparameters theta = model.hyperparameters();
  theta.noise_stddev = 0.0;
  expect_invalid(model.SetHyperparameters(theta), "noise_stddev");
  expect_invalid(model.SetHyperparameters(DefaultHyperparameters(CovarianceFunction::kArcsine, 5)),
                 "the covariance takes 5 inputs");
  EXPECT_FALSE(Predict(model, ViewOf(wide), PredictWhat::kMean).ok());
  EXPECT_FALSE(ExactModel::Create(nullptr, model.hyperparameters()).ok());
  EXPECT_FALSE(ExactModel::Create(TestContext(), theta).ok());
}

TEST(ExactModel, RefactorizingForgetsTheHistory) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(200, 6, generator);
  ExactModel wandering = MakeModel(DefaultHyperparameters(CovarianceFunction::kArcsine, 6));
  Add(points, 0, 130, 0, wandering);
  Add(points, 130, 200, 1, wandering);
  std::vector<int64_t> rows(100);
  std::iota(rows.begin(), rows.end(), int64_t{0});
  ASSERT_TRUE(wandering.Remove(absl::MakeConstSpan(rows).first(30)).ok());
  ASSERT_TRUE(wandering.Remove(absl::MakeConstSpan(rows).first(70)).ok());
  ExactModel fresh = MakeModel(DefaultHyperparameters(CovarianceFunction::kArcsine, 6));
  Add(points, 100, 200, 0, fresh);
  ASSERT_TRUE(wandering.Refactorize().ok());
  ASSERT_TRUE(fresh.Refactorize().ok());
  EXPECT_EQ(CopyOf(wandering.factor().Factor()), CopyOf(fresh.factor().Factor()));
  EXPECT_EQ(wandering.alpha(), fresh.alpha());
}

TEST(ExactModel, GpmlsNumbers) {
  const RegressionData data = GpmlDemo();
  ExactModel model = MakeModel(GpmlNeuralNetwork(0.0, 0.0, std::log(0.1)));
  ASSERT_TRUE(model.AddObservations({ViewOf(data.inputs), data.targets}, 0).ok());
  // GPML 3.6: infExact, covNNone. Tolerances: 1e-10 of the number.
  EXPECT_NEAR(model.LogMarginalLikelihood(), -224.6467058483673, 224.6 * 1e-10);
  const auto left_out = Value(model.PredictLeaveOneOut());
  const std::vector<double> densities = left_out.LogDensities(model.targets());
  EXPECT_NEAR(std::accumulate(densities.begin(), densities.end(), 0.0), -233.8821292629794,
              233.9 * 1e-10);
  RowMatrix queries(2, 1);
  queries << 0.0, 1.0;
  const auto prediction = Value(Predict(model, ViewOf(queries), PredictWhat::kMeanAndVariance));
  EXPECT_NEAR(prediction.mean[0], 1.366929392622168, 1.4e-10);
  EXPECT_NEAR(prediction.mean[1], 2.486821640898967, 2.5e-10);
  EXPECT_NEAR(prediction.variance[0] + 0.01, 0.01163764014804, 1e-12);
  EXPECT_NEAR(prediction.variance[1] + 0.01, 0.01511797539900, 1e-12);
}

}  // namespace
}  // namespace egosieve::gp
