// Posteriors on the caller's queue, from and to the caller's buffers.
#include <CL/opencl.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/kernels/ops/posterior_test.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

using PosteriorArgumentsTest = PosteriorTest;
constexpr int64_t kPoints = 50;
constexpr int64_t kQueries = 130;
constexpr float kUntouched = -77.0f;

// A context of the caller's with a queue, and the library's on top of it.
struct Caller {
  explicit Caller(cl_command_queue_properties properties = 0, Shapes shapes = Shapes::kOfTheDevice)
      : context(TestContext()->cl_device()),
        queue(context, TestContext()->cl_device(), properties) {
    ContextOptions options;
    if (shapes == Shapes::kLocalTiles) options.tuning = SmallLocalTiles();
    adopted = Value(AdoptContext(context(), nullptr, options));
  }
  cl::Buffer Filled(const std::vector<float>& values) const {
    const cl::Buffer buffer(context, CL_MEM_READ_WRITE, values.size() * sizeof(float));
    queue.enqueueWriteBuffer(buffer, CL_TRUE, 0, values.size() * sizeof(float), values.data());
    return buffer;
  }
  std::vector<float> Read(const cl::Buffer& buffer, int64_t count) const {
    std::vector<float> values(count);
    queue.enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(float), values.data());
    return values;
  }

  cl::Context context;
  cl::CommandQueue queue;
  std::shared_ptr<Context> adopted;
};

class DeviceQueueTest : public PosteriorTest {
 protected:
  DeviceQueueTest() {
    if (TestIsOnReference()) return;
    const CovarianceParameters covariance{
        .function = *CovarianceFunction::Parse("matern52"), .scales = {0.7, 1.3}, .dimension = 2};
    problem_ = MakeProblem(random_, covariance, kPoints, 0.3);
    queries_ = RandomQueries(random_, kQueries, 2);
  }
  void SetUp() override {
    if (TestIsOnReference()) GTEST_SKIP() << "the reference has no queues";
  }

  std::unique_ptr<DensePosterior> Make(const std::shared_ptr<Context>& context, int64_t cap = 0,
                                       FactorKind kind = FactorKind::kCholesky) const {
    return Value(DensePosterior::Create(context, problem_.model(kind), {.memory_cap_bytes = cap}));
  }
  // Of Evaluate, on the tests' own context with this shape.
  Results Expected(FactorKind kind = FactorKind::kCholesky) const {
    Results results(kQueries);
    const auto posterior = Make(context(), 0, kind);
    EXPECT_TRUE(posterior->Evaluate({queries_.data(), kQueries, 2}, results.outputs()).ok());
    return results;
  }

  Problem problem_;
  std::vector<float> queries_;
};

// Calls, waits, and gives the status.
absl::Status EnqueueAndWait(const DensePosterior& posterior, const BufferMatrix& queries,
                            const DeviceOutputs& outputs, const DeviceCall& call) {
  const auto event = posterior.Enqueue(queries, outputs, call);
  if (!event.ok()) return event.status();
  cl::Event(*event).wait();  // takes the reference over
  return absl::OkStatus();
}

TEST_P(DeviceQueueTest, GivesTheBitsOfEvaluate) {
  for (const FactorKind kind : {FactorKind::kCholesky, FactorKind::kInverseCholesky}) {
    for (const bool in_order : {true, false}) {
      for (const int64_t cap : {int64_t{0}, int64_t{1}}) {
        const Caller caller(in_order ? 0 : CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, GetParam());
        const auto posterior = Make(caller.adopted, cap, kind);
        const cl::Buffer queries = caller.Filled(queries_);
        const std::vector<float> empty(kQueries, kUntouched);
        const cl::Buffer mean = caller.Filled(empty), variance = caller.Filled(empty),
                         probability = caller.Filled(empty);
        DeviceOutputs outputs;
        outputs.mean.memory = mean();
        outputs.variance.memory = variance();
        outputs.probability.memory = probability();
        ASSERT_TRUE(
            EnqueueAndWait(*posterior, {queries(), kQueries}, outputs, {caller.queue()}).ok());
        const Results expected = Expected(kind);
        const std::vector<float> means = caller.Read(mean, kQueries),
                                 variances = caller.Read(variance, kQueries),
                                 probabilities = caller.Read(probability, kQueries);
        for (int64_t q = 0; q < kQueries; ++q) {
          ASSERT_EQ(means[q], expected.mean(0, q)) << q;
          ASSERT_EQ(variances[q], expected.variance(0, q)) << q;
          ASSERT_EQ(probabilities[q], expected.probability(0, q)) << q;
        }
      }
    }
  }
}

TEST_P(DeviceQueueTest, ReadsAndWritesWhereItIsTold) {
  const Caller caller(0, GetParam());
  const auto posterior = Make(caller.adopted);
  constexpr int64_t kStride = 5, kFirst = 3, kMeanFirst = 7, kVarianceFirst = 11;
  std::vector<float> spread(kFirst + kQueries * kStride, 1e6f);
  for (int64_t q = 0; q < kQueries; ++q) {
    std::copy_n(&queries_[q * 2], 2, &spread[kFirst + q * kStride]);
  }
  const cl::Buffer queries = caller.Filled(spread);
  const cl::Buffer mean = caller.Filled(std::vector<float>(kMeanFirst + kQueries + 1, kUntouched));
  const cl::Buffer variance =
      caller.Filled(std::vector<float>(kVarianceFirst + kQueries + 1, kUntouched));
  DeviceOutputs outputs{.mean = {mean(), kMeanFirst}, .variance = {variance(), kVarianceFirst}};
  ASSERT_TRUE(
      EnqueueAndWait(*posterior, {queries(), kQueries, kFirst, kStride}, outputs, {caller.queue()})
          .ok());
  const Results expected = Expected();
  const auto expect = [&](const cl::Buffer& buffer, int64_t first, const GuardedMatrix<float>& at) {
    const std::vector<float> values = caller.Read(buffer, first + kQueries + 1);
    for (int64_t i = 0; i < first; ++i) ASSERT_EQ(values[i], kUntouched);
    for (int64_t q = 0; q < kQueries; ++q) ASSERT_EQ(values[first + q], at(0, q));
    ASSERT_EQ(values[first + kQueries], kUntouched);
  };
  expect(mean, kMeanFirst, expected.mean);
  expect(variance, kVarianceFirst, expected.variance);
}

TEST_P(DeviceQueueTest, WaitsForTheCallersEventsAndOutlivesItsHandles) {
  Caller caller(0, GetParam());
  auto posterior = Make(caller.adopted);
  cl::Buffer queries = caller.Filled(std::vector<float>(queries_.size(), 1e6f));
  const cl::Buffer mean = caller.Filled(std::vector<float>(kQueries, kUntouched));
  const cl::CommandQueue other(caller.context, TestContext()->cl_device());
  cl::UserEvent gate(caller.context);
  const cl_event wait = gate();
  DeviceOutputs outputs;
  outputs.mean.memory = mean();
  const auto event =
      Value(posterior->Enqueue({queries(), kQueries}, outputs, {caller.queue(), &wait, 1}));
  const cl::Event done(event);
  EXPECT_NE(done.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>(), CL_COMPLETE);
  // What is there when the event comes counts.
  other.enqueueWriteBuffer(queries, CL_TRUE, 0, queries_.size() * sizeof(float), queries_.data());
  const Results expected = Expected();
  posterior.reset();
  caller.adopted.reset();
  queries = cl::Buffer();
  gate.setStatus(CL_COMPLETE);
  done.wait();
  const std::vector<float> means = caller.Read(mean, kQueries);
  for (int64_t q = 0; q < kQueries; ++q) ASSERT_EQ(means[q], expected.mean(0, q));
}

TEST_P(DeviceQueueTest, CountsClampedVariancesAndKeepsNotANumberToItsQuery) {
  const Caller caller(0, GetParam());
  const auto posterior = Make(caller.adopted, 1);  // tile by tile: the count is over all
  std::vector<float> with_nan = queries_;
  for (const int64_t q : {int64_t{4}, kQueries - 1}) {
    with_nan[q * 2] = std::numeric_limits<float>::quiet_NaN();
  }
  const cl::Buffer queries = caller.Filled(with_nan);
  const cl::Buffer mean = caller.Filled(std::vector<float>(kQueries, kUntouched));
  const cl::Buffer variance = caller.Filled(std::vector<float>(kQueries, kUntouched));
  const cl::Buffer clamped = caller.Filled({kUntouched, kUntouched, kUntouched});
  DeviceOutputs outputs;
  outputs.mean.memory = mean();
  outputs.variance.memory = variance();
  outputs.clamped = {clamped(), 1};
  ASSERT_TRUE(EnqueueAndWait(*posterior, {queries(), kQueries}, outputs, {caller.queue()}).ok());
  const Results expected = Expected();
  const std::vector<float> means = caller.Read(mean, kQueries),
                           variances = caller.Read(variance, kQueries);
  for (int64_t q = 0; q < kQueries; ++q) {
    const bool bad = std::isnan(with_nan[q * 2]);
    EXPECT_EQ(variances[q], bad ? 0.0f : expected.variance(0, q));
    if (bad) {
      EXPECT_TRUE(std::isnan(means[q]));
    } else {
      EXPECT_EQ(means[q], expected.mean(0, q));
    }
  }
  cl_int count[3];
  caller.queue.enqueueReadBuffer(clamped, CL_TRUE, 0, sizeof count, count);
  EXPECT_EQ(count[1], 2);
  const std::vector<float> around = caller.Read(clamped, 3);
  EXPECT_EQ(around[0], kUntouched);
  EXPECT_EQ(around[2], kUntouched);
}

TEST_P(DeviceQueueTest, NothingToDoEndsToo) {
  const Caller caller(0, GetParam());
  const auto posterior = Make(caller.adopted);
  EXPECT_TRUE(EnqueueAndWait(*posterior, {}, {}, {caller.queue()}).ok());
}

TEST_P(DeviceQueueTest, RefusesWhatDoesNotFit) {
  const Caller caller(0, GetParam()), stranger;
  const auto posterior = Make(caller.adopted);
  const cl::Buffer queries = caller.Filled(queries_), foreign = stranger.Filled(queries_);
  const cl::Buffer mean = caller.Filled(std::vector<float>(kQueries, kUntouched));
  const auto message = [&](const BufferMatrix& at, const DeviceOutputs& outputs,
                           const DeviceCall& call) {
    const absl::Status status = EnqueueAndWait(*posterior, at, outputs, call);
    EXPECT_THAT(status, IsInvalid());
    return std::string(status.message());
  };
  DeviceOutputs good;
  good.mean.memory = mean();
  const BufferMatrix all{queries(), kQueries};
  const DeviceCall call{caller.queue()};
  EXPECT_EQ(message(all, good, {}).rfind("queue", 0), 0u);
  EXPECT_EQ(message(all, good, {stranger.queue()}).rfind("queue", 0), 0u);
  cl::UserEvent event(stranger.context);
  const cl_event wait = event();
  EXPECT_EQ(message(all, good, {caller.queue(), &wait, 1}).rfind("wait[0]", 0), 0u);
  event.setStatus(CL_COMPLETE);  // NVIDIA's driver waits for it at the end
  EXPECT_EQ(message(all, good, {caller.queue(), nullptr, 1}).rfind("wait", 0), 0u);
  EXPECT_EQ(message({nullptr, kQueries}, good, call).rfind("queries", 0), 0u);
  EXPECT_EQ(message({foreign(), kQueries}, good, call).rfind("queries", 0), 0u);
  EXPECT_EQ(message({queries(), kQueries + 1}, good, call).rfind("queries", 0), 0u);
  EXPECT_EQ(message({queries(), kQueries, 1}, good, call).rfind("queries", 0), 0u);
  EXPECT_EQ(message({queries(), kQueries, 0, 1}, good, call).rfind("queries", 0), 0u);
  EXPECT_EQ(message({queries(), -1}, good, call).rfind("queries", 0), 0u);
  DeviceOutputs bad = good;
  bad.mean.first = 1;
  EXPECT_EQ(message(all, bad, call).rfind("mean", 0), 0u);
  bad = good;
  bad.variance.memory = foreign();
  EXPECT_EQ(message(all, bad, call).rfind("variance", 0), 0u);
  bad = good;
  bad.clamped = {mean(), kQueries};
  EXPECT_EQ(message(all, bad, call).rfind("clamped", 0), 0u);
  for (const float value : caller.Read(mean, kQueries)) ASSERT_EQ(value, kUntouched);
}

TEST(AdoptContext, RefusesNullAndOtherDevices) {
  EXPECT_THAT(AdoptContext(nullptr, nullptr), IsInvalid());
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no OpenCL context";
  const cl::Context context(TestContext()->cl_device());
  EXPECT_TRUE(AdoptContext(context(), TestContext()->cl_device()()).ok());
}

TEST(Reference, HasNoQueues) {
  const auto context = Value(OpenContext({.device = "reference"}));
  const PosteriorModel prior{.covariance = ArcsineParameters({1, 2, 3})};
  const auto posterior = Value(DensePosterior::Create(context, prior));
  EXPECT_EQ(posterior->Enqueue({}, {}, {}).status().code(), absl::StatusCode::kFailedPrecondition);
}

INSTANTIATE_TEST_SUITE_P(Shapes, DeviceQueueTest,
                         testing::Values(Shapes::kOfTheDevice, Shapes::kLocalTiles), NameOf);

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
  EXPECT_FALSE(DensePosterior::Create(context(), model, {.memory_cap_bytes = -1}).ok());
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
