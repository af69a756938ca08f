// Samples as functions: their moments, and that a sample is a function.
#include "gp/model/sample_paths.h"

#include <cmath>
#include <string>
#include <vector>

#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

constexpr int64_t kDimension = 2, kPoints = 30, kQueries = 4;

// Everything that a posterior may have: noise by point, two outputs, a mean function.
struct Problem {
  Hyperparameters theta;
  RowMatrix x, y, queries;
  std::vector<double> noise;

  Problem(const std::string& text, int64_t outputs, std::mt19937_64& generator)
      : theta(UnevenHyperparameters(*CovarianceFunction::Parse(text), kDimension)),
        x(RandomPoints(kPoints, kDimension, generator)),
        y(kPoints, outputs),
        queries(RandomPoints(kQueries, kDimension, generator)) {
    for (int64_t i = 0; i < kPoints; ++i) {
      for (int64_t c = 0; c < outputs; ++c) y(i, c) = std::sin((c + 3.0) * x(i, 0)) + x(i, 1);
      noise.push_back(0.2 * std::abs(x(i, 1)));
    }
    queries.row(1) = x.row(3);
  }
  Observations data() const { return {ViewOf(x), ViewOf(y), noise}; }
};

// Mean and products of deviations against the joint posterior. A mean of S independent values of
// deviation d has the deviation d / sqrt(S), and is normal for S this large: six of them, d taken
// from the values. The samples' moments are the posterior's for any number of frequencies.
template <typename Model>
void ExpectMoments(const Model& model, const Problem& problem, bool of_observation) {
  const PathOptions options{
      .count = 4000, .frequencies = 16, .seed = 7, .of_observation = of_observation};
  const auto paths = Value(model.DrawPaths(options));
  const std::vector<double> values = Value(paths->Evaluate(ViewOf(problem.queries)));
  const auto joint =
      Value(Value(model.MakeFloat64Posterior())->PredictJoint(ViewOf(problem.queries)));
  const int64_t k = model.outputs(), s = options.count;
  ASSERT_EQ(values.size(), static_cast<size_t>(kQueries * k * s));
  const auto expect_mean = [&](const Eigen::ArrayXd& of, double expected, const std::string& what) {
    const double mean = of.mean(), deviation = std::sqrt((of - mean).square().mean());
    EXPECT_NEAR(mean, expected, 6.0 * deviation / std::sqrt(1.0 * s)) << what;
  };
  for (int64_t c = 0; c < k; ++c) {
    std::vector<Eigen::ArrayXd> of;
    for (int64_t i = 0; i < kQueries; ++i) {
      of.emplace_back(Eigen::Map<const Eigen::ArrayXd>(&values[(i * k + c) * s], s));
      expect_mean(of[i], joint.mean[i * k + c], "mean " + std::to_string(i));
      of[i] -= joint.mean[i * k + c];
      for (int64_t j = 0; j <= i; ++j) {
        const double noise = of_observation && i == j ? problem.theta.noise_variance() : 0.0;
        expect_mean(of[i] * of[j], joint.covariance.row(i)[j] + noise,
                    "covariance " + std::to_string(i) + " " + std::to_string(j));
      }
    }
  }
}

constexpr const char* kStationary[] = {
    "squared_exponential",
    "matern12",
    "matern32",
    "matern52",
    "isotropic(matern32) * squared_exponential[1] + constant + matern52[0]",
};

TEST(SamplePaths, OfExactModelsHaveThePosteriorsMoments) {
  auto generator = TestGenerator();
  for (const char* text : kStationary) {
    SCOPED_TRACE(text);
    const Problem problem(text, 1, generator);
    auto model = Value(ExactModel::Create(TestContext(), problem.theta));
    ExpectMoments(model, problem, false);  // the prior
    ASSERT_TRUE(model.AddObservations(problem.data(), 0).ok());
    ExpectMoments(model, problem, false);
  }
  for (const MeanFunction mean : {MeanFunction::kConstant, MeanFunction::kLinear}) {
    Problem problem("matern52", 2, generator);
    problem.theta.mean = mean;
    auto model = Value(ExactModel::Create(TestContext(), problem.theta));
    ASSERT_TRUE(model.AddObservations(problem.data(), 0).ok());
    ExpectMoments(model, problem, true);
  }
}

TEST(SamplePaths, OfSparseModelsHaveTheirMoments) {
  auto generator = TestGenerator();
  for (const auto approximation : {SparseApproximation::kDtc, SparseApproximation::kFitc}) {
    const Problem problem("matern32", 1, generator);
    SparseModelOptions options{.approximation = approximation, .inducing_points = 8};
    options.relative_jitter = 0.5;  // large, so that it shows
    auto model = Value(SparseModel::Create(TestContext(), problem.theta, options));
    ExpectMoments(model, problem, false);
    ASSERT_TRUE(model.AddObservations(problem.data(), 0).ok());
    ExpectMoments(model, problem, false);
  }
}

TEST(SamplePaths, AreFunctions) {
  auto generator = TestGenerator();
  const Problem problem("matern52", 2, generator);
  auto model = Value(ExactModel::Create(TestContext(), problem.theta));
  ASSERT_TRUE(model.AddObservations(problem.data(), 0).ok());
  RowMatrix many = RandomPoints(900, kDimension, generator);  // more than a tile
  many.row(899) = many.row(13);
  many(5, 0) = 0.0;
  RowMatrix one = many.row(5);
  one(0, 0) = -0.0;
  for (const bool of_observation : {false, true}) {
    PathOptions options{.count = 3, .of_observation = of_observation};
    const auto paths = Value(model.DrawPaths(options));
    const std::vector<double> all = Value(paths->Evaluate(ViewOf(many)));
    const std::vector<double> alone = Value(paths->Evaluate(ViewOf(one)));
    options.count = 200;
    const auto more = Value(Value(model.DrawPaths(options))->Evaluate(ViewOf(one)));
    for (int64_t c = 0; c < 2; ++c) {
      for (int64_t s = 0; s < 3; ++s) {
        EXPECT_EQ(alone[c * 3 + s], all[5 * 6 + c * 3 + s]);
        EXPECT_EQ(all[899 * 6 + c * 3 + s], all[13 * 6 + c * 3 + s]);
        EXPECT_EQ(alone[c * 3 + s], more[c * 200 + s]);
      }
      EXPECT_NE(alone[c * 3], alone[c * 3 + 1]);
    }
    options.seed = 1;
    EXPECT_NE(more, Value(Value(model.DrawPaths(options))->Evaluate(ViewOf(one))));
  }
}

// Inputs such as seconds since 1970: phases are counted from the points' centre.
TEST(SamplePaths, FarFromZeroAreThoseBesideIt) {
  auto generator = TestGenerator();
  const Problem problem("matern52", 1, generator);
  const auto values = [&](double origin) {
    // Eighths, so that sums with 2^30 are exact, and so is the centre.
    const RowMatrix x = ((8.0 * problem.x).array().round() / 8.0 + 3.0 + origin).matrix();
    RowMatrix g = RowMatrix::Zero(kPoints, 1);
    Value(PriorPaths::Draw(problem.theta, ViewOf(x), 1, {}))
        .AddTo(ViewOf(x), {g.data(), kPoints, 1});
    return g;
  };
  EXPECT_EQ(values(0.0), values(0x1p30));
}

TEST(SamplePaths, RefuseWhatTheyCannotDraw) {
  auto generator = TestGenerator();
  for (const char* text : {"arcsine", "matern52 + linear", "matern52 * periodic", "white"}) {
    const Problem problem(text, 1, generator);
    const auto model = Value(ExactModel::Create(TestContext(), problem.theta));
    EXPECT_THAT(model.DrawPaths({}), IsError(absl::StatusCode::kUnimplemented, text));
  }
  const Problem problem("matern52", 1, generator);
  const auto model = Value(ExactModel::Create(TestContext(), problem.theta));
  EXPECT_THAT(model.DrawPaths({.frequencies = 0}), IsInvalid("frequencies is 0"));
  EXPECT_THAT(model.DrawPaths({.count = -1}), IsInvalid("count is -1"));
  EXPECT_TRUE(
      Value(Value(model.DrawPaths({.count = 0}))->Evaluate(ViewOf(problem.queries))).empty());
  RowMatrix bad = problem.queries;
  bad(0, 0) = std::nan("");
  EXPECT_THAT(Value(model.DrawPaths({}))->Evaluate(ViewOf(bad)), IsInvalid());
}

}  // namespace
}  // namespace egosieve::gp
