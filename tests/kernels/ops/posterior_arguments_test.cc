#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/ops/dense_posterior.h"
#include "tests/kernels/ops/posterior_test.h"
#include "tests/kernels/test_data.h"

namespace egosieve::kernels {
namespace {

using PosteriorArgumentsTest = PosteriorTest;

TEST_P(PosteriorArgumentsTest, BadQueriesAreNamedAndNothingIsWritten) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 1, 1, 1, 1, 1, 1}), 20, 0.3);
  auto posterior = DensePosterior::Create(context(), problem.model(FactorKind::kCholesky));
  ASSERT_TRUE(posterior.ok()) << posterior.status();
  std::vector<float> queries = RandomQueries(random_, 300, 6);
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
    queries[257 * 6 + 3] = bad;
    Results results(300);
    const auto counts =
        (*posterior)->Evaluate(ConstMatrixView<float>(queries.data(), 300, 6), results.outputs());
    EXPECT_EQ(counts.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(counts.status().message().find("queries(257, 3)"), std::string::npos)
        << counts.status();
    EXPECT_TRUE(results.mean.untouched() && results.variance.untouched() &&
                results.probability.untouched());
  }
  queries[257 * 6 + 3] = 0.0f;
  Results results(300);
  EXPECT_TRUE((*posterior)
                  ->Evaluate(ConstMatrixView<float>(queries.data(), 300, 6), results.outputs())
                  .ok());
  EXPECT_FALSE((*posterior)
                   ->Evaluate(ConstMatrixView<float>(queries.data(), 360, 5), results.outputs())
                   .ok());
}

TEST_P(PosteriorArgumentsTest, BadModelsAreNamed) {
  const auto message_of = [&](const PosteriorModel& model) {
    const auto posterior = DensePosterior::Create(context(), model);
    EXPECT_EQ(posterior.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(posterior.status().message());
  };
  Problem problem = MakeProblem(random_, ArcsineParameters({1, 1, 1}), 20, 0.3);
  PosteriorModel model = problem.model(FactorKind::kCholesky);
  model.factor.rows = 19;
  EXPECT_NE(message_of(model).find("factor is 19 x 20"), std::string::npos);
  model = problem.model(FactorKind::kCholesky);
  model.alpha = nullptr;
  EXPECT_NE(message_of(model).find("alpha"), std::string::npos);
  model = problem.model(FactorKind::kCholesky);
  model.squash_a = NAN;
  EXPECT_NE(message_of(model).find("squash_a = nan"), std::string::npos);
  for (const auto& [scales, words] : {std::pair{std::vector<double>{1.0}, "dimension 0"},
                                      {std::vector<double>(258, 1.0), "dimension 257"},
                                      {std::vector<double>{1.0, 0.0, 1.0}, "scales[1] = 0"},
                                      {std::vector<double>{1.0, 1.0, NAN}, "scales[2] = nan"}}) {
    model = problem.model(FactorKind::kCholesky);
    model.covariance = ArcsineParameters(scales);
    EXPECT_NE(message_of(model).find(words), std::string::npos) << message_of(model);
  }
  model = problem.model(FactorKind::kCholesky);
  model.covariance.signal_stddev = -1.0;
  EXPECT_NE(message_of(model).find("signal_stddev = -1"), std::string::npos);
  std::vector<double> bad_alpha(problem.alpha);
  bad_alpha[19] = NAN;
  model = problem.model(FactorKind::kCholesky);
  model.alpha = bad_alpha.data();
  EXPECT_NE(message_of(model).find("alpha"), std::string::npos);
  problem.cholesky[5 * 20 + 5] = 0.0;
  EXPECT_NE(message_of(problem.model(FactorKind::kCholesky)).find("factor(5, 5) = 0"),
            std::string::npos);
  problem.inputs[7] = INFINITY;
  EXPECT_NE(message_of(problem.model(FactorKind::kNone)).find("inputs(3, 1) = inf"),
            std::string::npos);
  DensePosteriorOptions options;
  options.memory_cap_bytes = 0;
  EXPECT_FALSE(DensePosterior::Create(context(), model, options).ok());
}

TEST_P(PosteriorArgumentsTest, VariancesOfAModelWithoutAFactorAreRefused) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 1, 1}), 20, 0.3);
  auto posterior = DensePosterior::Create(context(), problem.model(FactorKind::kNone));
  ASSERT_TRUE(posterior.ok()) << posterior.status();
  const float query[2] = {0.1f, 0.2f};
  Results results(1);
  EXPECT_EQ((*posterior)
                ->Evaluate(ConstMatrixView<float>(query, 1, 2), results.outputs())
                .status()
                .code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(
      (*posterior)->Evaluate(ConstMatrixView<float>(query, 1, 2), {results.mean.data()}).ok());
}

INSTANTIATE_TEST_SUITE_P(Shapes, PosteriorArgumentsTest,
                         testing::Values(Shapes::kOfTheDevice, Shapes::kLocalTiles,
                                         Shapes::kOwnMemory),
                         NameOf);

}  // namespace
}  // namespace egosieve::kernels
