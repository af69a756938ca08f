#include "gp/model/sparse_model.h"

#include <malloc.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "gp/model/exact_model.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/area_under_curve.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

constexpr SparseApproximation kAll[] = {SparseApproximation::kDtc, SparseApproximation::kFitc};

SparseModel MakeModel(const Hyperparameters& theta, const SparseModelOptions& options) {
  return Value(SparseModel::Create(TestContext(), theta, options));
}

// With noise by point; some points come after the inducing inputs.
TEST(SparseModel, AllPointsInducingIsTheExactModel) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(80, 4, generator);
  const std::vector<double> targets = points.targets();
  std::vector<double> noise;
  for (int i = 0; i < 80; ++i) noise.push_back(0.5 * (1.0 + points.inputs(i, 2)));
  const auto between = [&](int64_t begin, int64_t end) {
    return Observations(ViewOf(points.inputs).rows_between(begin, end),
                        absl::MakeConstSpan(targets).subspan(begin, end - begin),
                        absl::MakeConstSpan(noise).subspan(begin, end - begin));
  };
  const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 4);
  auto exact = Value(ExactModel::Create(TestContext(), theta));
  ASSERT_TRUE(exact.AddObservations(between(0, 80), 0).ok());
  const RowMatrix queries = RandomPoints(60, 4, generator);
  const auto expected = Value(Predict(exact, ViewOf(queries), PredictWhat::kMeanAndVariance));
  const auto left_out = Value(exact.PredictLeaveOneOut());
  const auto joint_of = [&](const auto& model) {
    const auto joint = Value(Value(model.MakeFloat64Posterior())->PredictJoint(ViewOf(queries)));
    return CopyOf(joint.covariance.view());
  };
  for (const auto approximation : kAll) {
    SparseModel model = MakeModel(
        theta, {.approximation = approximation, .refresh_share = 10.0, .relative_jitter = 1e-9});
    ASSERT_TRUE(model.AddObservations(between(0, 60), 0).ok());
    ASSERT_TRUE(model.SetInducingInputs(ViewOf(points.inputs)).ok());
    ASSERT_TRUE(model.AddObservations(between(60, 80), 1).ok());
    ASSERT_EQ(model.inducing_size(), 80);
    const auto found = Value(Predict(model, ViewOf(queries), PredictWhat::kMeanAndVariance));
    // K_uu's jitter, 1e-9 sigma_n^2, against its smallest pivots.
    for (int i = 0; i < 60; ++i) {
      EXPECT_NEAR(found.mean[i], expected.mean[i], 1e-6);
      EXPECT_NEAR(found.variance[i], expected.variance[i], 1e-6);
    }
    const RowMatrix joint = joint_of(model);
    EXPECT_LE((joint - joint_of(exact)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_NEAR(joint(3, 3), found.variance[3], 1e-12);
    EXPECT_NEAR(model.LogMarginalLikelihood(), exact.LogMarginalLikelihood(), 1e-5);
    const LeaveOneOut sparse_left_out = Value(model.PredictLeaveOneOut());
    for (int i = 0; i < 80; ++i) {
      EXPECT_NEAR(sparse_left_out.mean[i], left_out.mean[i], 2e-5);
      EXPECT_NEAR(sparse_left_out.target_variance[i], left_out.target_variance[i], 2e-5);
    }
  }
}

TEST(SparseModel, UpdatesAreTheModelOfThePoints) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(300, 3, generator);
  const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 3);
  const RowMatrix inducing = RandomPoints(40, 3, generator);
  const kernels::ConstMatrixView<double> x = ViewOf(points.inputs);
  for (const auto approximation : kAll) {
    const SparseModelOptions options{.approximation = approximation, .refresh_share = 1e9};
    SparseModel wandering = MakeModel(theta, options);
    ASSERT_TRUE(wandering.SetInducingInputs(ViewOf(inducing)).ok());
    for (int64_t begin = 0; begin < 300; begin += 60) {
      ASSERT_TRUE(wandering
                      .Add(x.rows_between(begin, begin + 60),
                           absl::MakeConstSpan(points.labels).subspan(begin, 60), begin)
                      .ok());
    }
    std::vector<int64_t> rows(200);
    std::iota(rows.begin(), rows.end(), int64_t{50});
    ASSERT_TRUE(wandering.Remove(rows).ok());
    ASSERT_EQ(wandering.size(), 100);
    EXPECT_EQ(wandering.points().identities[50], 250);

    SparseModel fresh = MakeModel(theta, options);
    ASSERT_TRUE(fresh.SetInducingInputs(ViewOf(inducing)).ok());
    RowMatrix left(100, 3);
    left << points.inputs.topRows(50), points.inputs.bottomRows(50);
    std::vector<double> labels = points.labels;
    labels.erase(labels.begin() + 50, labels.begin() + 250);
    ASSERT_TRUE(fresh.Add(ViewOf(left), labels, 0).ok());
    const RowMatrix queries = RandomPoints(40, 3, generator);
    const auto a = Value(Predict(wandering, ViewOf(queries), PredictWhat::kMeanAndVariance));
    const auto b = Value(Predict(fresh, ViewOf(queries), PredictWhat::kMeanAndVariance));
    for (int i = 0; i < 40; ++i) {
      // Sums of 300 terms of size up to 1 / 0.09, with 200 taken away: 1e-12 of A, whose inverse
      // is at most 1.
      EXPECT_NEAR(a.mean[i], b.mean[i], 1e-9);
      EXPECT_NEAR(a.variance[i], b.variance[i], 1e-9);
    }
  }
}

// Points that are there before the inducing inputs are projected a tile at a time, later ones at once.
TEST(SparseModel, TilesOfPointsAddUp) {
  auto generator = TestGenerator();
  const int64_t n = 2 * kRowTile + 300;
  const LabelledPoints points = NoisyBlobs(n, 2, generator);
  const std::vector<double> targets = points.targets();
  std::vector<double> noise(n);
  for (int64_t i = 0; i < n; ++i) noise[i] = 1e-3 * static_cast<double>(i % 97);
  const Observations data(ViewOf(points.inputs), targets, noise);
  const RowMatrix inducing = RandomPoints(9, 2, generator);
  SparseModelOptions options{.approximation = SparseApproximation::kFitc, .refresh_share = 1e9};
  const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 2);
  SparseModel tiled = MakeModel(theta, options), whole = MakeModel(theta, options);
  ASSERT_TRUE(tiled.AddObservations(data, 0).ok());
  for (SparseModel* model : {&tiled, &whole}) {
    ASSERT_TRUE(model->SetInducingInputs(ViewOf(inducing)).ok());
  }
  ASSERT_TRUE(whole.AddObservations(data, 0).ok());
  const auto a = Value(Predict(tiled, ViewOf(inducing), PredictWhat::kMeanAndVariance));
  const auto b = Value(Predict(whole, ViewOf(inducing), PredictWhat::kMeanAndVariance));
  for (int i = 0; i < 9; ++i) {
    // Sums of n terms: n eps of A, whose inverse is at most 1; 1e3 for the norms.
    EXPECT_NEAR(a.mean[i], b.mean[i], 1e3 * n * 2.2e-16);
    EXPECT_NEAR(a.variance[i], b.variance[i], 1e3 * n * 2.2e-16);
  }
  EXPECT_NEAR(tiled.LogMarginalLikelihood(), whole.LogMarginalLikelihood(), 1e3 * n * 2.2e-16 * n);
}

// v of (SP1) would take 8 n m bytes; the points take 48 n.
TEST(SparseModel, KeepsNothingOfSizeNTimesM) {
  auto generator = TestGenerator();
  const int64_t n = 20000, m = 200;
  const LabelledPoints points = NoisyBlobs(n, 2, generator);
  SparseModel model = MakeModel(DefaultHyperparameters(CovarianceFunction::kSquaredExponential, 2),
                                {.inducing_points = m});
  const auto in_use = [] {  // 0 under the sanitizers
    const struct mallinfo2 info = mallinfo2();
    return static_cast<int64_t>(info.uordblks + info.hblkhd);
  };
  ASSERT_TRUE(Predict(model, ViewOf(points.inputs), PredictWhat::kMean).ok());
  const int64_t before = in_use();
  ASSERT_TRUE(model.Add(ViewOf(points.inputs), points.labels, 0).ok());
  EXPECT_GT(model.inducing_size(), m / 2);
  EXPECT_LT(in_use() - before, 8 * n * m / 4);
}

TEST(SparseModel, LearnsAlmostAsTheExactModel) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(900, 6, generator);
  const LabelledPoints unseen = NoisyBlobs(500, 6, generator);
  const Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 6);
  auto exact = ExactModel::Create(TestContext(), theta);
  ASSERT_TRUE(exact->Add(ViewOf(points.inputs), points.labels, 0).ok());
  const auto expected = Predict(*exact, ViewOf(unseen.inputs), PredictWhat::kMean);
  std::vector<bool> is_high;
  for (const double label : unseen.labels) is_high.push_back(label >= 0.5);
  const double exact_area = AreaUnderCurve(expected->mean, is_high);
  const SparseModelOptions options{.inducing_points = 150};
  SparseModel model = MakeModel(theta, options);
  ASSERT_TRUE(model.Add(ViewOf(points.inputs), points.labels, 0).ok());
  EXPECT_LE(model.inducing_size(), 150);
  const auto found = Value(Predict(model, ViewOf(unseen.inputs), PredictWhat::kMean));
  EXPECT_GT(AreaUnderCurve(found.mean, is_high), exact_area - 0.02);
  SparseModel again = MakeModel(theta, options);
  ASSERT_TRUE(again.Add(ViewOf(points.inputs), points.labels, 0).ok());
  EXPECT_EQ(CopyOf(again.inducing_inputs()), CopyOf(model.inducing_inputs()));
}

TEST(SparseModel, EmptyAndEmptiedModelsAnswerWithThePrior) {
  const Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 2);
  SparseModel model = MakeModel(theta, {});
  const RowMatrix query = RowMatrix::Constant(1, 2, 0.5);
  const auto prior = Value(Predict(model, ViewOf(query), PredictWhat::kMeanAndVariance));
  EXPECT_EQ(prior.mean[0], 0.0);
  EXPECT_GT(prior.variance[0], 0.5);
  EXPECT_EQ(model.LogMarginalLikelihood(), 0.0);
  EXPECT_TRUE(model.MakePosterior({}).ok());
  ASSERT_TRUE(model.Add(ViewOf(query), {1.0}, 0).ok());
  EXPECT_GT(Predict(model, ViewOf(query), PredictWhat::kMean)->mean[0], 0.3);
  ASSERT_TRUE(model.Remove({0}).ok());
  EXPECT_EQ(Predict(model, ViewOf(query), PredictWhat::kMean)->mean[0], 0.0);
  // Duplicates alone: the pivoted choice takes one of them.
  const RowMatrix same = RowMatrix::Constant(700, 2, 0.5);
  ASSERT_TRUE(model.Add(ViewOf(same), std::vector<double>(700, 1.0), 1).ok());
  EXPECT_EQ(model.inducing_size(), 1);
}

// sigma_f^2 underflows to 0: no point is worth an inducing input.
TEST(SparseModel, PointsWithoutPriorVarianceCanBeRemoved) {
  Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 2);
  theta.covariance.signal_stddev = 1e-170;
  SparseModelOptions options{.refresh_share = 10.0};
  options.inducing_points = 3;  // fewer than the points, so that they are chosen
  SparseModel model = MakeModel(theta, options);
  const RowMatrix points = RowMatrix::Random(6, 2);
  ASSERT_TRUE(model.Add(ViewOf(points), std::vector<double>(6, 1.0), 0).ok());
  ASSERT_EQ(model.inducing_size(), 0);
  ASSERT_TRUE(model.Remove({1, 4}).ok());
  EXPECT_EQ(model.size(), 4);
  EXPECT_EQ(Predict(model, ViewOf(points), PredictWhat::kMean)->mean[0], 0.0);
}

TEST(SparseModel, ANoiseThatIsTooSmallIsRefusedAndChangesNothing) {
  const Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 2);
  SparseModel model = MakeModel(theta, {});
  const RowMatrix points = RowMatrix::Random(6, 2);
  ASSERT_TRUE(model.Add(ViewOf(points), std::vector<double>(6, 1.0), 0).ok());
  const double mean = Predict(model, ViewOf(points), PredictWhat::kMean)->mean[0];
  Hyperparameters extreme = theta;
  extreme.covariance.signal_stddev = 1e150;
  extreme.noise_stddev = 1e-150;
  EXPECT_EQ(model.SetHyperparameters(extreme).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(Predict(model, ViewOf(points), PredictWhat::kMean)->mean[0], mean);
}

TEST(SparseModel, VarianceFarFromAllPointsIsThePriors) {
  const Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kSquaredExponential, 2);
  const RowMatrix points = RowMatrix::Identity(2, 2), far = RowMatrix::Constant(1, 2, 1e4);
  SparseModel model = MakeModel(theta, {.approximation = SparseApproximation::kFitc});
  ASSERT_TRUE(model.Add(ViewOf(points), {1.0, 0.0}, 0).ok());
  const auto found = Value(Predict(model, ViewOf(far), PredictWhat::kMeanAndVariance));
  EXPECT_DOUBLE_EQ(found.variance[0], 1.0);
}

TEST(SparseModel, GoesOnFromItsStateBitForBit) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(400, 3, generator);
  const kernels::ConstMatrixView<double> x = ViewOf(points.inputs);
  const auto labels = absl::MakeConstSpan(points.labels);
  const SparseModelOptions options{.inducing_points = 60};
  SparseModel whole = MakeModel(DefaultHyperparameters(CovarianceFunction::kArcsine, 3), options);
  ASSERT_TRUE(whole.Add(x.rows_between(0, 200), labels.first(200), 0).ok());
  ASSERT_TRUE(whole.Add(x.rows_between(200, 230), labels.subspan(200, 30), 1).ok());
  ASSERT_TRUE(whole.Refresh().ok());
  auto resumed = Value(SparseModel::Restore(TestContext(), whole.State(), options));
  for (SparseModel* model : {&whole, &resumed}) {
    ASSERT_TRUE(model->Add(x.rows_between(230, 250), labels.subspan(230, 20), 2).ok());
    ASSERT_TRUE(model->Remove({1, 5, 100}).ok());
    ASSERT_TRUE(model->Add(x.rows_between(250, 400), labels.subspan(250, 150), 3).ok());
  }
  const auto a = Value(Predict(whole, x, PredictWhat::kMeanAndVariance));
  const auto b = Value(Predict(resumed, x, PredictWhat::kMeanAndVariance));
  EXPECT_EQ(a.mean, b.mean);
  EXPECT_EQ(a.variance, b.variance);
  EXPECT_EQ(whole.points().identities, resumed.points().identities);
}

TEST(SparseModel, JitterClimbsWhereInducingInputsAreAlike) {
  auto generator = TestGenerator();
  Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 2);
  theta.noise_stddev = 1e-6;  // its share of jitter is 1e-18: nothing
  SparseModel model = MakeModel(theta, {});
  RowMatrix inducing = RandomPoints(20, 2, generator);
  inducing.row(19) = inducing.row(4);
  ASSERT_TRUE(model.SetInducingInputs(ViewOf(inducing)).ok());
  EXPECT_EQ(model.inducing_size(), 20);
  EXPECT_GT(model.jitter(), 0.9e-10);
  EXPECT_LE(model.jitter(), 1e-4);
  ASSERT_TRUE(model.SetInducingInputs(ViewOf(RowMatrix(inducing.topRows(3)))).ok());
  EXPECT_LT(model.jitter(), 1e-17);
}

TEST(SparseModel, RefusesBadArguments) {
  const Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 2);
  EXPECT_FALSE(
      SparseModel::Create(TestContext(), theta, SparseModelOptions{.inducing_points = 0}).ok());
  EXPECT_FALSE(
      SparseModel::Create(TestContext(), theta, SparseModelOptions{.refresh_share = std::nan("")})
          .ok());
  EXPECT_FALSE(SparseModel::Create(nullptr, theta).ok());
  SparseModel model = MakeModel(theta, {});
  RowMatrix x = RowMatrix::Zero(2, 2);
  EXPECT_FALSE(model.Add(ViewOf(x), {0.5, 2.0}, 0).ok());
  x(1, 1) = std::nan("");
  EXPECT_FALSE(model.Add(ViewOf(x), {0.5, 0.5}, 0).ok());
  EXPECT_FALSE(model.Remove({0}).ok());
  EXPECT_EQ(model.size(), 0);
}

TEST(SparseModel, GpmlsFitc) {
  const RegressionData data = GpmlDemo();
  Hyperparameters theta;
  theta.covariance.function = CovarianceFunction::kSquaredExponential;
  theta.covariance.scales = {1.0};
  theta.noise_stddev = 0.1;
  SparseModel model = MakeModel(theta, {.approximation = SparseApproximation::kFitc,
                                        .refresh_share = std::numeric_limits<double>::infinity()});
  RowMatrix inducing(10, 1);
  for (int i = 0; i < 10; ++i) inducing(i, 0) = -1.3 + 2.6 * i / 9.0;
  ASSERT_TRUE(model.SetInducingInputs(ViewOf(inducing)).ok());
  ASSERT_TRUE(model.AddObservations({ViewOf(data.inputs), data.targets}, 0).ok());
  EXPECT_NEAR(model.LogMarginalLikelihood(), -153.9846295202831, 154.0 * 1e-10);
  RowMatrix queries(2, 1);
  queries << 0.0, 1.0;
  const auto prediction = Value(Predict(model, ViewOf(queries), PredictWhat::kMeanAndVariance));
  // The formulas in 60 digits; GPML prints variances that differ from these by its own rounding,
  // 4e-9 and 7e-10, because it forms the difference of two inverses.
  EXPECT_NEAR(prediction.mean[0], 1.56181714853809734, 1e-10);
  EXPECT_NEAR(prediction.mean[1], 1.53819066623621307, 1e-10);
  EXPECT_NEAR(prediction.variance[0] + 0.01, 0.0120096365425969990, 1e-10);
  EXPECT_NEAR(prediction.variance[1] + 0.01, 0.0231095441761217867, 1e-10);
}

}  // namespace
}  // namespace egosieve::gp
