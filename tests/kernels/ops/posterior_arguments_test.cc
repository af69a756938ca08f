#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/ops/dense_posterior.h"
#include "tests/kernels/ops/posterior_test.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

using PosteriorArgumentsTest = PosteriorTest;

TEST_P(PosteriorArgumentsTest, BadQueriesAreNamedAndNothingIsWritten) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 1, 1, 1, 1, 1, 1}), 20, 0.3);
  auto posterior = Value(DensePosterior::Create(context(), problem.model(FactorKind::kCholesky)));
  std::vector<float> queries = RandomQueries(random_, 300, 6);
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
    queries[257 * 6 + 3] = bad;
    Results results(300);
    EXPECT_THAT(
        posterior->Evaluate(ConstMatrixView<float>(queries.data(), 300, 6), results.outputs()),
        IsInvalid("queries(257, 3)"));
    EXPECT_TRUE(results.mean.untouched() && results.variance.untouched() &&
                results.probability.untouched());
  }
  queries[257 * 6 + 3] = 0.0f;
  Results results(300);
  EXPECT_TRUE(
      posterior->Evaluate(ConstMatrixView<float>(queries.data(), 300, 6), results.outputs()).ok());
  EXPECT_FALSE(
      posterior->Evaluate(ConstMatrixView<float>(queries.data(), 360, 5), results.outputs()).ok());
}

TEST_P(PosteriorArgumentsTest, BadModelsAreNamed) {
  const auto message_of = [&](const PosteriorModel& model) {
    const auto posterior = DensePosterior::Create(context(), model);
    EXPECT_THAT(posterior, IsInvalid());
    return std::string(posterior.status().message());
  };
  Problem problem = MakeProblem(random_, ArcsineParameters({1, 1, 1}), 20, 0.3);
  PosteriorModel model = problem.model(FactorKind::kCholesky);
  model.factor.rows = 19;
  EXPECT_THAT(message_of(model), testing::HasSubstr("factor is 19 x 20"));
  model = problem.model(FactorKind::kCholesky);
  model.alpha = nullptr;
  EXPECT_THAT(message_of(model), testing::HasSubstr("alpha"));
  model = problem.model(FactorKind::kCholesky);
  model.squash_a = NAN;
  EXPECT_THAT(message_of(model), testing::HasSubstr("squash_a = nan"));
  for (const auto& [scales, words] : {std::pair{std::vector<double>{1.0}, "dimension 0"},
                                      {std::vector<double>(258, 1.0), "dimension 257"},
                                      {std::vector<double>{1.0, 0.0, 1.0}, "scales[1] = 0"},
                                      {std::vector<double>{1.0, 1.0, NAN}, "scales[2] = nan"}}) {
    model = problem.model(FactorKind::kCholesky);
    model.covariance = ArcsineParameters(scales);
    EXPECT_THAT(message_of(model), testing::HasSubstr(words));
  }
  model = problem.model(FactorKind::kCholesky);
  model.covariance.signal_stddev = -1.0;
  EXPECT_THAT(message_of(model), testing::HasSubstr("signal_stddev = -1"));
  std::vector<double> bad_alpha(problem.alpha);
  bad_alpha[19] = NAN;
  model = problem.model(FactorKind::kCholesky);
  model.alpha = bad_alpha.data();
  EXPECT_THAT(message_of(model), testing::HasSubstr("alpha"));
  problem.cholesky[5 * 20 + 5] = 0.0;
  EXPECT_THAT(message_of(problem.model(FactorKind::kCholesky)),
              testing::HasSubstr("factor(5, 5) = 0"));
  problem.inputs[7] = INFINITY;
  EXPECT_THAT(message_of(problem.model(FactorKind::kNone)),
              testing::HasSubstr("inputs(3, 1) = inf"));
  DensePosteriorOptions options;
  options.memory_cap_bytes = 0;
  EXPECT_FALSE(DensePosterior::Create(context(), model, options).ok());
}

TEST_P(PosteriorArgumentsTest, VariancesOfAModelWithoutAFactorAreRefused) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 1, 1}), 20, 0.3);
  auto posterior = Value(DensePosterior::Create(context(), problem.model(FactorKind::kNone)));
  const float query[2] = {0.1f, 0.2f};
  Results results(1);
  EXPECT_EQ(
      posterior->Evaluate(ConstMatrixView<float>(query, 1, 2), results.outputs()).status().code(),
      absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(posterior->Evaluate(ConstMatrixView<float>(query, 1, 2), {results.mean.data()}).ok());
}

INSTANTIATE_TEST_SUITE_P(Shapes, PosteriorArgumentsTest,
                         testing::Values(Shapes::kOfTheDevice, Shapes::kLocalTiles,
                                         Shapes::kOwnMemory),
                         NameOf);

}  // namespace
}  // namespace egosieve::kernels
