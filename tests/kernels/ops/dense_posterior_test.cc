#include "kernels/ops/dense_posterior.h"

#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "kernels/base/prepared_points.h"
#include "kernels/reference/dense_posterior.h"
#include "kernels/runtime/tuning.h"
#include "tests/kernels/ops/posterior_test.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

class DensePosteriorTest : public PosteriorTest {
 protected:
  void ExpectMatchesReference(const Problem& problem, FactorKind kind, double noise_stddev,
                              int64_t m, std::shared_ptr<Context> on = nullptr) {
    const int64_t dimension = problem.covariance.input_dimension();
    const std::vector<float> queries = RandomQueries(random_, m, dimension);
    ExpectMatchesReference(
        *Value(DensePosterior::Create(on != nullptr ? on : context(), problem.model(kind))),
        problem.model(kind), noise_stddev, ConstMatrixView<float>(queries.data(), m, dimension));
  }
  template <typename T>
  static void ExpectMatchesReference(const DensePosterior& posterior, const PosteriorModel& model,
                                     double noise_stddev, ConstMatrixView<T> view) {
    const int64_t m = view.rows;
    Results results(m);
    ASSERT_EQ(posterior.Evaluate(view, results.outputs()).status(), absl::OkStatus());
    EXPECT_TRUE(results.guards_intact());
    std::vector<double> mean(m), variance(m), probability(m);
    reference::DensePosterior(model).Evaluate(view, mean.data(), variance.data(),
                                              probability.data());
    const PosteriorErrorBounds bounds = ErrorBounds(model, noise_stddev);
    for (int64_t q = 0; q < m; ++q) {
      ASSERT_NEAR(results.mean(0, q), mean[q], bounds.mean) << "query " << q << " of " << m;
      ASSERT_NEAR(results.variance(0, q), variance[q], bounds.variance)
          << "query " << q << " of " << m;
      ASSERT_NEAR(results.probability(0, q), probability[q], bounds.probability)
          << "query " << q << " of " << m;
    }
  }
};

TEST_P(DensePosteriorTest, AgreesWithTheReferenceAtSizesAroundEveryBlock) {
  const CovarianceParameters covariance =
      ArcsineParameters({1.0, 1.5, 2.0, 0.7, 1.0, 0.9, 1.1}, 1.3);
  for (const int64_t n : {1, 7, 8, 9, 63, 64, 65, 95, 96, 97, 191, 192, 193, 300, 391}) {
    const Problem problem = MakeProblem(random_, covariance, n, 0.3);
    for (const FactorKind kind : {FactorKind::kCholesky, FactorKind::kInverseCholesky}) {
      SCOPED_TRACE(testing::Message() << "n = " << n << ", factor kind " << static_cast<int>(kind));
      ExpectMatchesReference(problem, kind, 0.3, 50);
    }
  }
}

TEST_P(DensePosteriorTest, AgreesWithTheReferenceAtNumbersOfQueriesAroundEveryTile) {
  const Problem problem =
      MakeProblem(random_, SquaredExponentialParameters({0.5, 1.5, 2.0}, 0.8), 120, 0.2);
  for (const int64_t m :
       {0, 1, 15, 16, 17, 31, 32, 33, 47, 48, 49, 63, 64, 65, 95, 191, 192, 193, 400}) {
    ExpectMatchesReference(problem, FactorKind::kCholesky, 0.2, m);
  }
}

TEST_P(DensePosteriorTest, EveryDimensionUpToTheMaximumWorks) {
  // Tiles in local memory take seconds to compile. At 12 the points of a block are what needs most
  // of it.
  const std::vector<int64_t> dimensions = GetParam() == Shapes::kLocalTiles
                                              ? std::vector<int64_t>{12}
                                              : std::vector<int64_t>{1, 2, 5, 31, 32};
  for (const int64_t dimension : dimensions) {
    const std::vector<double> scales(dimension + 1, 0.8);
    const Problem problem = MakeProblem(random_, ArcsineParameters(scales), 50, 0.3);
    ExpectMatchesReference(problem, FactorKind::kCholesky, 0.3, 20);
  }
}

// In 4 KiB there are blocks of 8 rows, and the mean alone takes 8 points at once; in 2 KiB there
// are no blocks.
TEST_P(DensePosteriorTest, WidePointsWorkInLittleLocalMemory) {
  if (GetParam() != Shapes::kLocalTiles) GTEST_SKIP() << "has no tiles in local memory";
  const double noise = 0.3;
  const Problem problem = MakeProblem(random_, WideParameters(), 75, noise);
  constexpr int64_t kQueries = 20;
  const std::vector<float> queries = RandomQueries(random_, kQueries, 32);
  const ConstMatrixView<float> view(queries.data(), kQueries, 32);
  for (const int64_t bytes : {4096, 2048}) {
    SCOPED_TRACE(bytes);
    const std::shared_ptr<Context> little = OpenLittleLocalMemory(bytes);
    ASSERT_NE(little, nullptr);
    ExpectMatchesReference(problem, FactorKind::kCholesky, noise, kQueries, little);
    auto posterior = Value(DensePosterior::Create(little, problem.model(FactorKind::kCholesky)));
    Results all(kQueries), alone(kQueries);
    ASSERT_TRUE(posterior->Evaluate(view, all.outputs()).ok());
    ASSERT_TRUE(posterior->Evaluate(view, {alone.mean.data()}).ok());
    EXPECT_TRUE(alone.guards_intact());
    for (int64_t q = 0; q < kQueries; ++q) ASSERT_EQ(alone.mean(0, q), all.mean(0, q)) << q;
  }
}

// With one training point and alpha = 1 the mean is the covariance itself.
TEST_P(DensePosteriorTest, BothFormsOfTheArcsineKeepTheErrorBelowOneMillionth) {
  const double alpha = 1.0;
  for (const auto& [weight, is_plain] :
       {std::pair{0.05, true}, {0.3, true}, {4.0, false}, {300.0, false}}) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      const std::vector<double> input = RandomPoints(random_, 1, 6);
      const PosteriorModel model{.covariance = ArcsineParameters(std::vector<double>(7, weight)),
                                 .inputs = ConstMatrixView<double>(input.data(), 1, 6),
                                 .alpha = &alpha};
      const PointPreparation preparation(model.covariance);
      std::vector<float> prepared(preparation.width());
      preparation.Prepare(input.data(), prepared.data(), 1);
      EXPECT_THAT(model.covariance.function.description().DeviceCode(
                      {.dimension = 6, .points = {prepared.data(), 1, preparation.width()}}),
                  testing::HasSubstr(is_plain ? "#if !1" : "#if !0"));
      auto posterior = Value(DensePosterior::Create(context(), model));
      std::vector<float> queries = RandomQueries(random_, 64, 6);
      // The same point, moved little by little, and its mirror image.
      for (int q = 0; q < 32; ++q) {
        for (int d = 0; d < 6; ++d) {
          queries[q * 6 + d] =
              static_cast<float>((q % 2 == 0 ? 1 : -1) * input[d] * (1.0 - std::ldexp(1.0, -q)));
        }
      }
      GuardedMatrix<float> mean(1, 64);
      ASSERT_TRUE(
          posterior->Evaluate(ConstMatrixView<float>(queries.data(), 64, 6), {mean.data()}).ok());
      for (int q = 0; q < 64; ++q) {
        double point[6];
        std::copy_n(&queries[q * 6], 6, point);
        ASSERT_NEAR(mean(0, q),
                    static_cast<double>(ExactCovariance(model.covariance, point, input.data())),
                    1e-6);
      }
    }
  }
}

TEST_P(DensePosteriorTest, WithoutTrainingPointsItIsThePrior) {
  Problem problem;
  problem.covariance = ArcsineParameters({1.0, 2.0}, 1.5);
  PosteriorModel model = problem.model(FactorKind::kCholesky);
  auto posterior = Value(DensePosterior::Create(context(), model));
  const float queries[] = {-0.5f, 0.0f, 0.75f};
  Results results(3);
  ASSERT_TRUE(posterior->Evaluate(ConstMatrixView<float>(queries, 3, 1), results.outputs()).ok());
  for (int q = 0; q < 3; ++q) {
    const double x = queries[q];
    EXPECT_EQ(results.mean(0, q), 0.0f);
    // Two roundings of a value below 4.
    EXPECT_NEAR(results.variance(0, q),
                static_cast<double>(ExactCovariance(problem.covariance, &x, &x)), 1e-6);
  }
}

TEST_P(DensePosteriorTest, OutputsThatAreNotAskedForChangeNothingElse) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 1, 1, 1, 1, 1, 1}), 130, 0.3);
  auto posterior = Value(DensePosterior::Create(context(), problem.model(FactorKind::kCholesky)));
  const std::vector<float> queries = RandomQueries(random_, 100, 6);
  const ConstMatrixView<float> view(queries.data(), 100, 6);
  Results all(100);
  ASSERT_TRUE(posterior->Evaluate(view, all.outputs()).ok());
  for (int mask = 1; mask < 7; ++mask) {
    Results some(100);
    const PosteriorOutputs outputs = {mask & 1 ? some.mean.data() : nullptr,
                                      mask & 2 ? some.variance.data() : nullptr,
                                      mask & 4 ? some.probability.data() : nullptr};
    ASSERT_TRUE(posterior->Evaluate(view, outputs).ok());
    for (int q = 0; q < 100; ++q) {
      if (mask & 1) {
        EXPECT_EQ(some.mean(0, q), all.mean(0, q)) << mask << " " << q;
      }
      if (mask & 2) {
        EXPECT_EQ(some.variance(0, q), all.variance(0, q));
      }
      if (mask & 4) {
        EXPECT_EQ(some.probability(0, q), all.probability(0, q));
      }
    }
    EXPECT_EQ(some.mean.untouched(), !(mask & 1));
    EXPECT_EQ(some.variance.untouched(), !(mask & 2));
    EXPECT_EQ(some.probability.untouched(), !(mask & 4));
  }
}

TEST_P(DensePosteriorTest, ResultsDoNotDependOnTheTileBitForBit) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 1, 1, 1, 1, 1, 1}), 205, 0.3);
  const int64_t m = 700;
  const std::vector<float> queries = RandomQueries(random_, m, 6);
  Results whole(m);
  for (const FactorKind kind : {FactorKind::kCholesky, FactorKind::kInverseCholesky}) {
    auto posterior = Value(DensePosterior::Create(context(), problem.model(kind)));
    ASSERT_TRUE(
        posterior->Evaluate(ConstMatrixView<float>(queries.data(), m, 6), whole.outputs()).ok());
    const DensePosteriorOptions small{.memory_cap_bytes = 1};
    auto capped = Value(DensePosterior::Create(context(), problem.model(kind), small));
    for (const int64_t begin : {0, 1, 17, 333, 690}) {
      Results part(m - begin);
      ASSERT_TRUE(
          capped
              ->Evaluate(ConstMatrixView<float>(&queries[begin * 6], m - begin, 6), part.outputs())
              .ok());
      ExpectSame(part, whole, m - begin, begin);
    }
  }
}

TEST_P(DensePosteriorTest, QueriesMayHaveAStride) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 2, 3}), 40, 0.3);
  auto posterior = Value(DensePosterior::Create(context(), problem.model(FactorKind::kNone)));
  const std::vector<float> queries = RandomQueries(random_, 70, 2);
  std::vector<float> apart(70 * 5, std::numeric_limits<float>::quiet_NaN());
  for (int q = 0; q < 70; ++q) std::copy_n(&queries[q * 2], 2, &apart[q * 5]);
  Results dense(70), strided(70);
  ASSERT_TRUE(
      posterior->Evaluate(ConstMatrixView<float>(queries.data(), 70, 2), {dense.mean.data()}).ok());
  ASSERT_TRUE(
      posterior->Evaluate(ConstMatrixView<float>(apart.data(), 70, 2, 5), {strided.mean.data()})
          .ok());
  for (int q = 0; q < 70; ++q) ASSERT_EQ(strided.mean(0, q), dense.mean(0, q));
}

// The first input is a time in seconds since 1970, where steps of float32 are 128. Centred and
// scaled it is within 5, and its rounding changes a covariance by at most 0.6 x 10 u < 4e-7.
TEST_P(DensePosteriorTest, QueriesInFloat64AreRoundedAfterTheyAreCentred) {
  const double noise = 0.3;
  const int64_t m = 400;
  Problem problem = MakeProblem(random_, SquaredExponentialParameters({0.2, 1.5, 2.0}), 100, noise);
  problem.covariance = SquaredExponentialParameters({600.0, 1.5, 2.0});
  std::vector<double> queries = RandomPoints(random_, m, 3);
  for (std::vector<double>* points : {&problem.inputs, &queries}) {
    for (size_t i = 0; i < points->size(); i += 3) (*points)[i] = 1.7e9 + 3000.0 * (*points)[i];
  }
  const PosteriorModel model = problem.model(FactorKind::kCholesky);
  auto posterior = Value(DensePosterior::Create(context(), model));
  const ConstMatrixView<double> view(queries.data(), m, 3);
  ExpectMatchesReference(*posterior, model, noise, view);
  queries[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(posterior->Evaluate(view, Results(m).outputs()), IsInvalid("queries(2, 1)"));
}

TEST_P(DensePosteriorTest, QueriesOfFloat32ValuesGiveTheSameBitsInFloat64) {
  const int64_t m = 400;
  for (const CovarianceParameters& covariance :
       {ArcsineParameters({1, 1, 1, 1, 1, 1, 1}), SquaredExponentialParameters({0.5, 1.5, 2.0})}) {
    const int64_t dimension = covariance.input_dimension();
    const Problem problem = MakeProblem(random_, covariance, 80, 0.3);
    auto posterior = Value(DensePosterior::Create(context(), problem.model(FactorKind::kCholesky)));
    const std::vector<float> narrow = RandomQueries(random_, m, dimension);
    const std::vector<double> wide(narrow.begin(), narrow.end());
    Results expected(m), results(m);
    ASSERT_TRUE(posterior->Evaluate({narrow.data(), m, dimension}, expected.outputs()).ok());
    ASSERT_TRUE(posterior->Evaluate({wide.data(), m, dimension}, results.outputs()).ok());
    ExpectSame(results, expected, m);
  }
}

TEST_P(DensePosteriorTest, ShapesOfTheKernelsChangeRoundingAlone) {
  if (GetParam() != Shapes::kOfTheDevice) GTEST_SKIP() << "opens its own";
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no shapes";
  const double noise = 0.3;
  const Problem problem =
      MakeProblem(random_, ArcsineParameters({1, 1, 1, 1, 1, 1, 1}), 205, noise);
  const std::vector<float> queries = RandomQueries(random_, 100, 6);
  const ConstMatrixView<float> view(queries.data(), 100, 6);
  std::vector<double> variance(100);
  reference::DensePosterior(problem.model(FactorKind::kCholesky))
      .Evaluate<float, double>(view, nullptr, variance.data(), nullptr);
  // Every shape is compiled: few, but each lane count and panels that divide neither n nor the
  // depth.
  std::vector<KernelTuning> shapes = {SmallLocalTiles(), DefaultGpuTuning()};
  shapes[0].panel = 3;
  shapes[0].depth = 12;
  for (const auto& [lanes, panel] : {std::pair{1, 5}, {4, 1}, {8, 6}, {16, 7}}) {
    shapes.push_back(DefaultTuning(lanes));
    if (lanes == 1) shapes.back().work_group = 4;
    shapes.back().panel = panel;
    shapes.back().depth = 24;
    shapes.back().panels_per_group = 3;
  }
  for (const KernelTuning& shape : shapes) {
    const auto context = Value(OpenContext({.tuning = shape}));
    for (const FactorKind kind : {FactorKind::kCholesky, FactorKind::kInverseCholesky}) {
      // Seconds to compile; the products of an inverse take the same loops.
      if (shape.panel % 2 == 0 && kind != FactorKind::kCholesky) continue;
      auto posterior = Value(DensePosterior::Create(context, problem.model(kind)));
      Results results(100);
      ASSERT_TRUE(posterior->Evaluate(view, results.outputs()).ok());
      EXPECT_TRUE(results.guards_intact());
      const double bound = ErrorBounds(problem.model(kind), noise).variance;
      for (int q = 0; q < 100; ++q) ASSERT_NEAR(results.variance(0, q), variance[q], bound);
    }
  }
}

TEST_P(DensePosteriorTest, OnePosteriorServesSeveralThreads) {
  const Problem problem = MakeProblem(random_, ArcsineParameters({1, 1, 1, 1, 1, 1, 1}), 150, 0.3);
  auto posterior = Value(DensePosterior::Create(context(), problem.model(FactorKind::kCholesky)));
  const std::vector<float> queries = RandomQueries(random_, 500, 6);
  const ConstMatrixView<float> view(queries.data(), 500, 6);
  Results expected(500);
  ASSERT_TRUE(posterior->Evaluate(view, expected.outputs()).ok());
  std::vector<Results> results(4, Results(500));
  std::vector<int> failures(4, 0);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int repeat = 0; repeat < 10; ++repeat) {
        failures[t] += posterior->Evaluate(view, results[t].outputs()).ok() ? 0 : 1;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (int t = 0; t < 4; ++t) {
    EXPECT_EQ(failures[t], 0);
    ExpectSame(results[t], expected, 500);
  }
}

TEST_P(DensePosteriorTest, NegativeVariancesAreClampedAndCounted) {
  // A factor that is too small by a thousand makes |L^-1 k*|^2 a million times too large.
  Problem problem = MakeProblem(random_, ArcsineParameters({1, 1, 1, 1, 1, 1, 1}), 40, 0.3);
  for (double& value : problem.cholesky) value *= 1e-3;
  auto posterior = Value(DensePosterior::Create(context(), problem.model(FactorKind::kCholesky)));
  const std::vector<float> queries = RandomQueries(random_, 61, 6);
  Results results(61);
  const auto counts =
      Value(posterior->Evaluate(ConstMatrixView<float>(queries.data(), 61, 6), results.outputs()));
  EXPECT_EQ(counts.clamped_variances, 61);
  for (int q = 0; q < 61; ++q) EXPECT_EQ(results.variance(0, q), 0.0f);
}

INSTANTIATE_TEST_SUITE_P(Shapes, DensePosteriorTest,
                         testing::Values(Shapes::kOfTheDevice, Shapes::kLocalTiles,
                                         Shapes::kOwnMemory),
                         NameOf);

}  // namespace
}  // namespace egosieve::kernels
