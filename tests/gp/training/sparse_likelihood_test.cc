#include "gp/training/sparse_likelihood.h"

#include <cmath>
#include <vector>

#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "gtest/gtest.h"
#include "tests/gp/learning_problems.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

constexpr SparseObjective kBoth[] = {SparseObjective::kVfe, SparseObjective::kFitc};

struct Problem {
  RowMatrix x, inducing;
  std::vector<double> y, noise;
  Hyperparameters theta;

  Problem(const char* function, int64_t n, int64_t m) {
    auto generator = TestGenerator();
    theta = UnevenHyperparameters(*CovarianceFunction::Parse(function), 3);
    x = RandomPoints(n, 3, generator);
    inducing = RandomPoints(m, 3, generator);
    for (int64_t i = 0; i < n; ++i) {
      y.push_back(std::sin(3.0 * x(i, 0)) + x(i, 1));
      noise.push_back(0.1 * std::abs(x(i, 2)));
    }
  }
  Observations data() const { return {ViewOf(x), absl::MakeConstSpan(y), noise}; }

  MarginalLikelihood At(const Hyperparameters& there, const RowMatrix& u,
                        SparseObjective objective) const {
    SparseLikelihoodOptions options;
    options.objective = objective;
    return Value(ComputeSparseLikelihood(*TestContext(), there, data(), ViewOf(u),
                                         LikelihoodOrder::kValueAndGradient, options));
  }
};

TEST(SparseLikelihood, GradientsAreFiniteDifferences) {
  for (const char* function : {"arcsine", "matern32", "linear + squared_exponential"}) {
    for (const SparseObjective objective : kBoth) {
      const Problem problem(function, 60, 9);
      const MarginalLikelihood at = problem.At(problem.theta, problem.inducing, objective);
      const std::vector<double> theta = ToLogarithms(problem.theta);
      ASSERT_EQ(at.gradient.size(), theta.size());
      for (size_t t = 0; t < theta.size(); ++t) {
        // Five-point rule: h^4 / 30 times a fifth derivative of the value's size or so, and
        // eps cond(A) / h of it.
        const auto value = [&](double step) {
          std::vector<double> moved = theta;
          moved[t] += step;
          return problem.At(*FromLogarithms(problem.theta, moved), problem.inducing, objective)
              .value;
        };
        EXPECT_NEAR(at.gradient[t], FivePointSlope(value, 1e-3), 1e-7 * (1.0 + std::abs(at.value)))
            << function << " theta_" << t;
      }
    }
  }
}

TEST(SparseLikelihood, IsTheExactOneWithAllPointsInducing) {
  const Problem problem("arcsine", 50, 1);
  const auto exact = Value(ComputeMarginalLikelihood(*TestContext(), problem.theta, problem.data(),
                                                     LikelihoodOrder::kValueAndGradient));
  for (const SparseObjective objective : kBoth) {
    const MarginalLikelihood sparse = problem.At(problem.theta, problem.x, objective);
    // K_uu's jitter, 1e-6 sigma_n^2, moves Q by as much, and the trace by n 1e-6 / 2.
    EXPECT_NEAR(sparse.value, exact.value, 1e-3);
    for (size_t t = 0; t < exact.gradient.size(); ++t) {
      EXPECT_NEAR(sparse.gradient[t], exact.gradient[t], 1e-2) << "theta_" << t;
    }
  }
}

TEST(SparseLikelihood, VfeIsABoundThatInducingInputsTighten) {
  const Problem problem("squared_exponential", 80, 12);
  const auto exact = Value(ComputeMarginalLikelihood(*TestContext(), problem.theta, problem.data(),
                                                     LikelihoodOrder::kValue));
  double before = -INFINITY;
  for (int64_t m = 1; m <= 12; ++m) {
    const RowMatrix u = problem.inducing.topRows(m);
    const double bound = problem.At(problem.theta, u, SparseObjective::kVfe).value;
    // Titsias (2009): more inducing inputs never loosen the bound; the jitter is 1e-6 of the noise.
    EXPECT_GE(bound, before - 1e-3);
    EXPECT_LE(bound, exact.value + 1e-3);
    before = bound;
  }
}

TEST(SparseLikelihood, FitcIsTheModelsOwn) {
  const Problem problem("matern52", 70, 10);
  SparseModelOptions options;
  options.approximation = SparseApproximation::kFitc;
  auto model = Value(SparseModel::Create(TestContext(), problem.theta, options));
  ASSERT_TRUE(model.AddObservations(problem.data(), 0).ok());
  ASSERT_TRUE(model.SetInducingInputs(ViewOf(problem.inducing)).ok());
  EXPECT_NEAR(problem.At(problem.theta, problem.inducing, SparseObjective::kFitc).value,
              model.LogMarginalLikelihood(), 1e-10 * 70);
}

TEST(SparseLikelihood, RefusesWhatItIsNotOf) {
  Problem problem("arcsine", 10, 3);
  const auto code = [&](const Observations& data, const RowMatrix& u, double jitter = 1e-6) {
    SparseLikelihoodOptions options;
    options.relative_jitter = jitter;
    return ComputeSparseLikelihood(*TestContext(), problem.theta, data, ViewOf(u),
                                   LikelihoodOrder::kValue, options)
        .status()
        .code();
  };
  EXPECT_EQ(code(problem.data(), problem.inducing), absl::StatusCode::kOk);
  EXPECT_EQ(code(problem.data(), RowMatrix(0, 3)), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code(problem.data(), RowMatrix::Zero(2, 2)), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code(problem.data(), problem.inducing, -1.0), absl::StatusCode::kInvalidArgument);
  const RowMatrix two = RowMatrix::Ones(10, 2);
  EXPECT_EQ(code({ViewOf(problem.x), ViewOf(two)}, problem.inducing),
            absl::StatusCode::kInvalidArgument);
  problem.theta.mean = MeanFunction::kConstant;
  EXPECT_EQ(code(problem.data(), problem.inducing), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace egosieve::gp
