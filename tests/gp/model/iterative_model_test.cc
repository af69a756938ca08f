#include "gp/model/iterative_model.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "gp/linalg/not_positive_definite.h"
#include "gp/model/exact_model.h"
#include "kernels/base/parallel_for.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

constexpr int kOutputs = 3;

// Points in four dimensions, three targets and noise of their own.
struct Problem {
  RowMatrix x, y, queries;
  std::vector<double> noise;
  Observations data() const { return {ViewOf(x), ViewOf(y), noise}; }
};

Problem MakeProblem(int64_t n, std::mt19937_64& generator) {
  Problem problem{RandomPoints(n, 4, generator), RowMatrix(n, kOutputs),
                  RandomPoints(100, 4, generator), std::vector<double>(n)};
  const RowMatrix random = RandomPoints(n, kOutputs, generator);
  for (int64_t i = 0; i < n; ++i) {
    const auto x = problem.x.row(i);
    problem.y.row(i) << std::sin(3.0 * x[0]) * x[1], x[2] + x[3] * x[3],
        10.0 * std::cos(5.0 * x[3]);
    problem.y.row(i) += 0.3 * random.row(i);
    problem.noise[i] = 1e-3 * static_cast<double>(i % 97);
  }
  return problem;
}

IterativeModelOptions OptionsOf(double tolerance, int64_t rank) {
  IterativeModelOptions options;
  options.gradients.tolerance = tolerance;
  options.rank = rank;
  return options;
}

IterativeModel ModelOf(const Hyperparameters& theta, const Problem& problem,
                       const IterativeModelOptions& options) {
  IterativeModel model = Value(IterativeModel::Create(TestContext(), theta, options));
  EXPECT_EQ(model.AddObservations(problem.data(), 0), absl::OkStatus());
  return model;
}

std::vector<double> MeansOf(const IterativeModel& model, const RowMatrix& queries) {
  std::vector<double> means(queries.rows() * model.outputs());
  EXPECT_TRUE(
      Value(model.MakeFloat64Posterior())->Evaluate(ViewOf(queries), means.data(), nullptr).ok());
  return means;
}

class IterativeModelOf : public testing::TestWithParam<const char*> {};

TEST_P(IterativeModelOf, HasTheMeansOfTheFactor) {
  auto generator = TestGenerator();
  // More than a tile of products, and not a multiple of it.
  const Problem problem = MakeProblem(kProductTile + 301, generator);
  const Hyperparameters theta =
      UnevenHyperparameters(Value(CovarianceFunction::Parse(GetParam())), 4);
  ExactModel exact = Value(ExactModel::Create(TestContext(), theta));
  ASSERT_EQ(exact.AddObservations(problem.data(), 0), absl::OkStatus());
  const auto expected = Value(Predict(exact, ViewOf(problem.queries), PredictWhat::kMean));
  const IterativeModel model = ModelOf(theta, problem, OptionsOf(1e-11, 100));
  EXPECT_FALSE(model.report().has_value());
  const std::vector<double> means = MeansOf(model, problem.queries);
  for (size_t i = 0; i < means.size(); ++i) EXPECT_NEAR(means[i], expected.mean[i], 1e-8);
  EXPECT_LE(model.report()->residual, 1e-11);
  EXPECT_GT(model.report()->iterations, 0);
  // In float32 on the device, too.
  std::vector<float> narrow(means.size());
  const auto posterior = Value(model.MakePosterior(SquashParameters{}));
  ASSERT_TRUE(posterior->Evaluate(ViewOf(problem.queries), {narrow.data()}).ok());
  for (size_t i = 0; i < means.size(); ++i) EXPECT_NEAR(narrow[i], means[i], 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Covariances, IterativeModelOf,
                         testing::Values("arcsine", "squared_exponential", "matern12", "matern52",
                                         "matern52[0:3] * periodic[3]", "matern32 + white",
                                         "linear[0, 2]"));

// (IM3), and the residual told is the true one.
TEST(IterativeModel, ErrorsAreWithinTheBound) {
  auto generator = TestGenerator();
  const Problem problem = MakeProblem(500, generator);
  const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kSquaredExponential, 4);
  RowMatrix k = GramOf(theta, problem.x);
  for (int i = 0; i < 500; ++i) k(i, i) += problem.noise[i];
  const RowMatrix exact = Covariances(theta, problem.queries, problem.x) * k.llt().solve(problem.y);
  for (const double tolerance : {1e-2, 1e-5}) {
    const IterativeModel model = ModelOf(theta, problem, OptionsOf(tolerance, 20));
    const std::vector<double> means = MeansOf(model, problem.queries);
    const auto solution = Value(model.Solve());
    const Eigen::Map<const RowMatrix> alpha(solution->weights.alpha.data(), 500, kOutputs);
    const RowMatrix left = problem.y - k * alpha;
    double largest = 0.0;
    for (int c = 0; c < kOutputs; ++c) {
      const double size = problem.y.col(c).norm(), residual = left.col(c).norm() / size;
      largest = std::max(largest, residual);
      const double bound =
          theta.covariance.signal_stddev / theta.noise_stddev * solution->report.residual * size;
      for (int q = 0; q < 100; ++q) {
        EXPECT_NEAR(means[q * kOutputs + c], exact(q, c), bound * (1.0 + 1e-6));
      }
    }
    EXPECT_LE(largest, tolerance);
    EXPECT_NEAR(largest, solution->report.residual, 1e-9 * tolerance + 1e-12);
  }
}

TEST(IterativeModel, RankSavesIterations) {
  auto generator = TestGenerator();
  const Problem problem = MakeProblem(600, generator);
  const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kSquaredExponential, 4);
  std::vector<int64_t> iterations;
  for (const int64_t rank : {1, 60, 600}) {
    iterations.push_back(
        Value(ModelOf(theta, problem, OptionsOf(1e-8, rank)).Solve())->report.iterations);
  }
  EXPECT_LT(iterations[1], iterations[0] * 2 / 3);
  EXPECT_LE(iterations[2], 4);  // M is K_y but for the jitter
}

TEST(IterativeModel, TellsWhatItCannotSolve) {
  auto generator = TestGenerator();
  const Problem problem = MakeProblem(400, generator);
  Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kSquaredExponential, 4);
  IterativeModelOptions few = OptionsOf(1e-10, 5);
  few.gradients.iterations = 4;
  IterativeModel model = ModelOf(theta, problem, few);
  for (int i = 0; i < 2; ++i) {  // nothing is kept
    const absl::Status status = model.MakeFloat64Posterior().status();
    EXPECT_TRUE(IsNotPositiveDefinite(status)) << status;
    EXPECT_FALSE(model.report().has_value());
  }
  EXPECT_FALSE(model.MakePosterior(SquashParameters{}).ok());
  // K + sigma_n^2 I is singular to working precision.
  Problem same = problem;
  same.noise.clear();
  same.x.bottomRows(200) = same.x.topRows(200);
  theta.noise_stddev = 1e-9;
  const absl::Status singular = ModelOf(theta, same, OptionsOf(1e-8, 50)).Solve().status();
  EXPECT_EQ(singular.code(), absl::StatusCode::kFailedPrecondition) << singular;
}

TEST(IterativeModel, DependsOnItsPointsAlone) {
  auto generator = TestGenerator();
  const Problem problem = MakeProblem(400, generator);
  const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 4);
  const IterativeModelOptions options = OptionsOf(1e-8, 40);
  Problem first = problem;
  first.x = problem.x.topRows(300);
  first.y = problem.y.topRows(300);
  first.noise.resize(300);
  const std::vector<double> expected = MeansOf(ModelOf(theta, first, options), problem.queries);
  Hyperparameters other = theta;
  other.noise_stddev = 0.7;
  IterativeModel model = ModelOf(other, problem, options);
  EXPECT_NE(MeansOf(model, problem.queries), expected);
  EXPECT_EQ(model.Remove({400}).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(model.report().has_value());
  std::vector<int64_t> last(100);
  std::iota(last.begin(), last.end(), int64_t{300});
  ASSERT_EQ(model.Remove(last), absl::OkStatus());
  EXPECT_FALSE(model.report().has_value());
  MeansOf(model, problem.queries);
  ASSERT_EQ(model.SetHyperparameters(theta), absl::OkStatus());
  kernels::SetMaximumThreads(1);
  const std::vector<double> on_one_thread = MeansOf(model, problem.queries);
  kernels::SetMaximumThreads(0);
  EXPECT_EQ(on_one_thread, expected);
}

TEST(IterativeModel, RestoresFromItsWeights) {
  auto generator = TestGenerator();
  const Problem problem = MakeProblem(400, generator);
  const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 4);
  const IterativeModelOptions options = OptionsOf(1e-9, 40);
  const IterativeModel model = ModelOf(theta, problem, options);
  std::vector<double> alpha = Value(model.Solve())->weights.alpha;
  const auto restored = [&](const std::vector<double>& from) {
    return Value(IterativeModel::Restore(TestContext(), model.State(), options, from));
  };
  const auto again = Value(restored(alpha).Solve());
  EXPECT_EQ(again->report.iterations, 0);
  EXPECT_EQ(again->report.residual, model.report()->residual);
  EXPECT_EQ(again->weights.alpha, alpha);
  for (double& value : alpha) value += 0.01;  // wrong weights are not believed
  const auto mended = Value(restored(alpha).Solve());
  EXPECT_GT(mended->report.iterations, 0);
  EXPECT_LE(mended->report.residual, 1e-9);
  alpha.pop_back();
  EXPECT_EQ(IterativeModel::Restore(TestContext(), model.State(), options, alpha).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(IterativeModel, RefusesWhatNeedsAFactor) {
  auto generator = TestGenerator();
  const Problem problem = MakeProblem(50, generator);
  Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 4);
  const auto posterior = Value(ModelOf(theta, problem, {}).MakeFloat64Posterior());
  const auto queries = ViewOf(problem.queries);
  std::vector<double> variances(problem.queries.rows());
  for (const absl::Status& status :
       {posterior->Evaluate(queries, nullptr, variances.data()).status(),
        posterior->PredictJoint(queries).status(), posterior->Sample(queries, {}).status(),
        posterior->PredictGradients(queries, PredictWhat::kMeanAndVariance).status()}) {
    EXPECT_THAT(status, IsError(absl::StatusCode::kFailedPrecondition, "means alone"));
  }
  EXPECT_TRUE(posterior->PredictGradients(queries, PredictWhat::kMean).ok());
  std::vector<float> narrow(variances.size());
  EXPECT_EQ(Value(ModelOf(theta, problem, {}).MakePosterior(SquashParameters{}))
                ->Evaluate(queries, {.variance = narrow.data()})
                .status()
                .code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(IterativeModel::Create(TestContext(), theta, OptionsOf(1e-8, 0)).status().code(),
            absl::StatusCode::kInvalidArgument);
  theta.mean = MeanFunction::kConstant;
  EXPECT_EQ(IterativeModel::Create(TestContext(), theta).status().code(),
            absl::StatusCode::kUnimplemented);
}

TEST(IterativeModel, WithoutPointsIsThePrior) {
  const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 4);
  const IterativeModel model = Value(IterativeModel::Create(TestContext(), theta));
  EXPECT_EQ(MeansOf(model, RowMatrix::Ones(2, 4)), std::vector<double>(2, 0.0));
}

// The most memory of this process since `reset`, bytes; 0 where the system does not tell.
int64_t PeakMemory(bool reset) {
  if (reset) std::ofstream("/proc/self/clear_refs") << 5;
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    int64_t kilobytes = 0;
    if (word == "VmHWM:" && status >> kilobytes) return 1024 * kilobytes;
  }
  return 0;
}

// K would take 8 n^2 bytes, 288 MB.
TEST(IterativeModel, KeepsNothingOfSizeNTimesN) {
  auto generator = TestGenerator();
  const int64_t n = 6000, rank = 50;
  const Problem problem = MakeProblem(n, generator);
  const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kSquaredExponential, 4);
  const int64_t before = PeakMemory(true);
  if (before == 0) GTEST_SKIP() << "the system tells no peak";
  const IterativeModel model = ModelOf(theta, problem, OptionsOf(1e-2, rank));
  MeansOf(model, problem.queries);
  const int64_t said = 8 * n * (4 + rank + 7 * kOutputs) + 8 * kProductTile * kProductTile;
  // The driver's program and the tiles of the prediction come on top.
  EXPECT_LE(PeakMemory(false) - before, said + 60'000'000);
}

}  // namespace
}  // namespace egosieve::gp
