// The exact model on devices with memory of their own, where the factor is computed: the model of
// the host's factor, and unchanged where the device fails.
#include <CL/cl.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "kernels/ops/exact_regression.h"
#include "tests/gp/learning_problems.h"
#include "tests/kernels/failing_calls.h"
#include "tests/testing/status.h"

namespace egosieve::gp {
namespace {

using kernels::CovarianceFunction;

constexpr int64_t kPoints = 150, kMore = 10;

std::shared_ptr<kernels::Context> OwnMemory() {
  static const auto context = Value(kernels::OpenContext({.shared_memory = false}));
  return context;
}

bool IsOnReference() { return !kernels::RegressesOnDevice(*OwnMemory()); }

ExactModel MakeModel(std::shared_ptr<kernels::Context> context, const Hyperparameters& theta) {
  return Value(ExactModel::Create(std::move(context), theta));
}

// The same up to rounding, which cond(K_y) = |K_y| / noise magnifies: below 1e4 here.
void ExpectSame(const ExactModel& actual, const ExactModel& expected) {
  constexpr double kTolerance = 1e-10;
  ASSERT_EQ(actual.size(), expected.size());
  EXPECT_EQ(actual.jitter(), expected.jitter());
  for (int64_t i = 0; i < actual.size(); ++i) {
    EXPECT_NEAR(actual.alpha()[i], expected.alpha()[i], kTolerance);
    for (int64_t j = 0; j < actual.size(); ++j) {
      ASSERT_NEAR(actual.factor().Factor()(i, j), expected.factor().Factor()(i, j), kTolerance);
    }
  }
  EXPECT_NEAR(actual.LogMarginalLikelihood(), expected.LogMarginalLikelihood(), 1e-8);
}

TEST(DeviceFactor, IsThatOfTheHost) {
  if (IsOnReference()) GTEST_SKIP() << "the reference has no device";
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(kPoints + kMore, 3, generator);
  const std::vector<double> targets = points.targets();
  std::vector<double> noise;
  for (int64_t i = 0; i < kPoints + kMore; ++i) noise.push_back(0.01 * static_cast<double>(i % 7));
  Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 3);
  ExactModel here = MakeModel(TestContext(), theta), there = MakeModel(OwnMemory(), theta);
  const auto change = [&](auto body) {
    for (ExactModel* model : {&here, &there}) {
      ASSERT_EQ(body(*model), absl::OkStatus());
    }
    ExpectSame(there, here);
  };
  const auto part = [&](int64_t begin, int64_t end) {
    return Observations(ViewOf(points.inputs).rows_between(begin, end),
                        absl::MakeConstSpan(targets).subspan(begin, end - begin),
                        absl::MakeConstSpan(noise).subspan(begin, end - begin));
  };
  change([&](ExactModel& model) { return model.AddObservations(part(0, kPoints), 0); });
  change(
      [&](ExactModel& model) { return model.AddObservations(part(kPoints, kPoints + kMore), 1); });
  change([&](ExactModel& model) { return model.Remove({0, 70, 71, 159}); });
  theta.noise_stddev = 0.5;
  change([&](ExactModel& model) { return model.SetHyperparameters(theta); });
}

TEST(DeviceFactor, JitterClimbsThereToo) {
  if (IsOnReference()) GTEST_SKIP() << "the reference has no device";
  Hyperparameters theta = DefaultHyperparameters(CovarianceFunction::kArcsine, 2);
  theta.noise_stddev = 1e-12;
  ExactModel model = MakeModel(OwnMemory(), theta);
  auto generator = TestGenerator();
  RowMatrix x = RandomPoints(20, 2, generator);
  x.row(19) = x.row(4);
  ASSERT_TRUE(model.Add(ViewOf(x), std::vector<double>(20, 1.0), 0).ok());
  EXPECT_GT(model.jitter(), 0.0);
  EXPECT_LE(model.jitter(), 1e-4);
}

// Also shows that it is the device that factorises.
TEST(DeviceFactor, ADeviceThatFailsLeavesTheModel) {
  if (IsOnReference()) GTEST_SKIP() << "the reference has no device";
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(40, 2, generator);
  const Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kArcsine, 2);
  ExactModel model = MakeModel(OwnMemory(), theta);
  ASSERT_TRUE(model
                  .Add(ViewOf(points.inputs).rows_between(0, 15),
                       absl::MakeConstSpan(points.labels).subspan(0, 15), 0)
                  .ok());
  const std::vector<double> alpha(model.alpha().begin(), model.alpha().end());
  Hyperparameters other = theta;
  other.noise_stddev = 0.9;
  const std::vector<std::function<absl::Status()>> changes = {
      [&] {
        return model.Add(ViewOf(points.inputs).rows_between(15, 40),
                         absl::MakeConstSpan(points.labels).subspan(15, 25), 1);
      },
      [&] { return model.SetHyperparameters(other); }};
  for (const auto& change : changes) {
    kernels::FailCall("clEnqueueFillBuffer", 0, CL_OUT_OF_RESOURCES);
    const absl::Status status = change();
    ASSERT_TRUE(kernels::CallHasFailed());
    EXPECT_THAT(status, IsError(absl::StatusCode::kResourceExhausted, "factorising on the device"));
    EXPECT_EQ(std::vector<double>(model.alpha().begin(), model.alpha().end()), alpha);
    EXPECT_EQ(model.hyperparameters().noise_stddev, theta.noise_stddev);
  }
  EXPECT_TRUE(changes[0]().ok());
  EXPECT_EQ(model.size(), 40);
}

// Means and variances at points of which some lie far from the model's, of one posterior here and
// one in the device's memory.
template <typename Model>
void ExpectSamePredictions(const Model& here, const Model& there) {
  auto generator = TestGenerator();
  const RowMatrix queries = 2.0 * RandomPoints(300, 3, generator);
  for (const PredictWhat what : {PredictWhat::kMean, PredictWhat::kMeanAndVariance}) {
    const auto expected = Value(Predict(here, ViewOf(queries), what));
    const auto actual = Value(Predict(there, ViewOf(queries), what));
    EXPECT_THAT(actual.mean, testing::Pointwise(testing::DoubleNear(1e-9), expected.mean));
    EXPECT_THAT(actual.variance, testing::Pointwise(testing::DoubleNear(1e-9), expected.variance));
  }
}

TEST(DeviceFactor, PredictsThereInFloat64) {
  if (IsOnReference()) GTEST_SKIP() << "the reference has no device";
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(kPoints, 3, generator);
  RowMatrix targets = RandomPoints(kPoints, 2, generator);
  Hyperparameters theta = UnevenHyperparameters(CovarianceFunction::kSquaredExponential, 3);
  for (const MeanFunction mean : {MeanFunction::kZero, MeanFunction::kLinear}) {
    theta.mean = mean;
    ExactModel here = MakeModel(TestContext(), theta), there = MakeModel(OwnMemory(), theta);
    for (ExactModel* model : {&here, &there}) {
      ASSERT_TRUE(model->AddObservations({ViewOf(points.inputs), ViewOf(targets)}, 0).ok());
    }
    ExpectSamePredictions(here, there);
  }
  theta.mean = MeanFunction::kZero;
  const auto sparse = [&](const std::shared_ptr<kernels::Context>& context) {
    auto model = SparseModel::Create(context, theta, {.inducing_points = 90});
    EXPECT_TRUE(model.ok() &&
                model->AddObservations({ViewOf(points.inputs), points.labels}, 0).ok());
    return *std::move(model);
  };
  ExpectSamePredictions(sparse(TestContext()), sparse(OwnMemory()));
}

// Also shows that it is the device that predicts, and that a failure leaves the posterior usable.
TEST(DeviceFactor, APredictionThatFailsThereSaysSo) {
  if (IsOnReference()) GTEST_SKIP() << "the reference has no device";
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(40, 2, generator);
  ExactModel model = MakeModel(OwnMemory(), UnevenHyperparameters(CovarianceFunction::kArcsine, 2));
  ASSERT_TRUE(model.Add(ViewOf(points.inputs), points.labels, 0).ok());
  const auto predict = [&] {
    return Predict(model, ViewOf(points.inputs), PredictWhat::kMeanAndVariance).status();
  };
  for (int call = 0; call < 2; ++call) {
    kernels::FailCall("clEnqueueReadBuffer", call, CL_OUT_OF_RESOURCES);
    const absl::Status status = predict();
    ASSERT_TRUE(kernels::CallHasFailed());
    EXPECT_THAT(status, IsError(absl::StatusCode::kResourceExhausted,
                                "predicting in float64 on the device"));
  }
  EXPECT_TRUE(predict().ok());
}

}  // namespace
}  // namespace egosieve::gp
