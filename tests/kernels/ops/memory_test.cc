// What reaches the device: the model once, then the queries alone.
#include <CL/cl.h>
#include <sys/resource.h>

#include <CL/opencl.hpp>
#include <cstdint>
#include <fstream>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "kernels/ops/dense_posterior.h"
#include "kernels/reference/dense_posterior.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/opencl_context.h"
#include "tests/kernels/failing_calls.h"
#include "tests/kernels/ops/posterior_test.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

constexpr int64_t kQueries = 500;

std::unique_ptr<DensePosterior> MakePosterior(std::shared_ptr<Context> context, int64_t n) {
  return Value(MakeDiagonalPosterior(std::move(context), n));
}

void Evaluate(const DensePosterior& posterior, int64_t count, int64_t dimension = 2) {
  const std::vector<float> queries(count * dimension, 0.25f);
  std::vector<float> mean(count), variance(count);
  EXPECT_TRUE(posterior
                  .Evaluate(ConstMatrixView<float>(queries.data(), count, dimension),
                            {mean.data(), variance.data(), nullptr})
                  .ok());
}

struct Bytes {
  int64_t of_model = 0;
  std::vector<int64_t> of_evaluations;
};

Bytes HandedOver(int64_t n) {
  Bytes bytes;
  TakeHostBytes();
  const auto posterior = MakePosterior(TestContext(), n);
  bytes.of_model = TakeHostBytes();
  for (int call = 0; call < 3; ++call) {
    Evaluate(*posterior, kQueries);
    bytes.of_evaluations.push_back(TakeHostBytes());
  }
  return bytes;
}

TEST(Uploads, LaterEvaluationsTakeTheQueriesAlone) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference uploads nothing";
  const Bytes small = HandedOver(200), large = HandedOver(600);
  const int64_t triangle = 600 * 600 / 2 * static_cast<int64_t>(sizeof(float));
  EXPECT_GE(large.of_model, triangle);
  EXPECT_EQ(small.of_evaluations, large.of_evaluations);  // whatever the size of the model
  for (const int64_t bytes : large.of_evaluations) {
    EXPECT_EQ(bytes, large.of_evaluations[0]);
    // A prepared query has at most D + 2 values; chunks are padded to tiles, fewer than 1,024 more.
    const int64_t results = 3 * kQueries + 4;
    EXPECT_LE(bytes, ((kQueries + 1024) * 4 + results) * static_cast<int64_t>(sizeof(float)));
    EXPECT_GE(bytes, kQueries * 2 * static_cast<int64_t>(sizeof(float)));
  }
}

// Of the means and variances of `count` queries, where the device has memory of its own.
int64_t ResultBytes(const Context& context, int64_t count) {
  return context.shares_host_memory() ? 0 : 2 * count * static_cast<int64_t>(sizeof(float));
}

// With tiles in local memory, as GPUs have them, a group holds one tile.
TEST(Uploads, OneQueryTakesTheScratchOfOneTile) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no scratch";
  constexpr int64_t kPoints = 208;  // a multiple of the group's rows
  const std::shared_ptr<Context> context = OpenLocalTiles();
  const auto posterior = MakePosterior(context, kPoints);
  const KernelTuning tuning = SmallLocalTiles();
  const auto scratch_for = [&](int64_t queries) {
    context->ReleaseIdle();
    TakeScratchBytes();
    Evaluate(*posterior, queries);
    return TakeScratchBytes() - ResultBytes(*context, queries);
  };
  const int64_t columns = tuning.width * tuning.work_group / tuning.panels_per_group;
  EXPECT_EQ(scratch_for(1), kPoints * columns * static_cast<int64_t>(sizeof(float)));
  EXPECT_EQ(scratch_for(columns + 1), 2 * scratch_for(1));
}

// Where local memory is too small for the block's points, blocks have half the rows and tiles twice
// the queries.
TEST(Uploads, WidePointsTakeTheScratchOfASmallerBlock) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no scratch";
  constexpr int64_t kPoints = 205;
  const std::shared_ptr<Context> context = OpenLittleLocalMemory(4096);
  ASSERT_NE(context, nullptr);
  const auto posterior = Value(MakeDiagonalPosterior(context, kPoints, {}, WideParameters()));
  const KernelTuning tuning = SmallLocalTiles();
  const int64_t panels = tuning.panels_per_group / 2, rows = tuning.panel * panels;
  const int64_t columns = tuning.width * tuning.work_group / panels;
  TakeScratchBytes();
  Evaluate(*posterior, 1, 32);
  const int64_t padded = (kPoints + rows - 1) / rows * rows;
  EXPECT_EQ(TakeScratchBytes() - ResultBytes(*context, 1),
            padded * columns * static_cast<int64_t>(sizeof(float)));
}

// The context keeps scratch memory for the next call.
TEST(Uploads, LaterEvaluationsTakeNoScratch) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no scratch";
  const auto posterior = MakePosterior(TestContext(), 200);
  TestContext()->ReleaseIdle();
  TakeScratchBytes();
  Evaluate(*posterior, kQueries);
  EXPECT_GT(TakeScratchBytes(), ResultBytes(*TestContext(), kQueries));
  for (int call = 0; call < 3; ++call) {
    Evaluate(*posterior, kQueries);
    EXPECT_EQ(TakeScratchBytes(), ResultBytes(*TestContext(), kQueries));
  }
}

// With queries and results in the device's memory nothing crosses at all.
TEST(Uploads, EnqueuedEvaluationsTakeNothing) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no queues";
  Context& context = *TestContext();
  const auto posterior = MakePosterior(TestContext(), 600);
  std::vector<float> queries(kQueries * 2, 0.25f);
  const cl::Buffer points(context.cl_context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                          queries.size() * sizeof(float), queries.data());
  const cl::Buffer results(context.cl_context(), CL_MEM_WRITE_ONLY, 2 * kQueries * sizeof(float));
  const cl::CommandQueue queue(context.cl_context(), context.cl_device());
  const DeviceOutputs outputs{.mean = {results(), 0}, .variance = {results(), kQueries}};
  for (int call = 0; call < 3; ++call) {
    TakeHostBytes();
    const auto event = Value(posterior->Enqueue({points(), kQueries}, outputs, {queue()}));
    cl::Event(event).wait();
    EXPECT_EQ(TakeHostBytes(), 0);
  }
}

// Memory that an evaluation takes: bounded by the cap, whatever the number of queries.

int64_t PeakBytes() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return int64_t{usage.ru_maxrss} << 10;
}

// n = 1000, queries by the hundred thousand: the n x M array of
// covariances would take 800 MB.
TEST(MemoryCap, TheWholeCovarianceIsNeverInMemory) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no cap, and its tiles are 64 queries";
  std::mt19937_64 random = TestRandom();
  const int64_t n = 1000;
  const int64_t m = 60000;
  const DensePosteriorOptions options{.memory_cap_bytes = int64_t{16} << 20};
  const double noise = 0.3;
  const Problem problem = MakeProblem(random, ArcsineParameters({1, 2, 3}), n, noise);
  const PosteriorModel model = problem.model(FactorKind::kCholesky);
  const auto posterior = Value(DensePosterior::Create(TestContext(), model, options));
  std::vector<float> queries(m * 2);
  for (float& value : queries) value = static_cast<float>(Uniform(random, -1, 1));
  std::vector<float> mean(m), variance(m), probability(m);
  const PosteriorOutputs outputs = {mean.data(), variance.data(), probability.data()};
  // Compiles, and touches everything once.
  ASSERT_TRUE(posterior->Evaluate(ConstMatrixView<float>(queries.data(), 500, 2), outputs).ok());
  std::fill(mean.begin(), mean.end(), 1.0f);
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak begins anew
  const int64_t before = PeakBytes();
  ASSERT_TRUE(posterior->Evaluate(ConstMatrixView<float>(queries.data(), m, 2), outputs).ok());
  // As much again for the allocator.
  EXPECT_LE(PeakBytes() - before, 2 * options.memory_cap_bytes);
  // Some of the results, from the first to the last.
  constexpr int64_t kStep = 997;
  const reference::DensePosterior reference(model);
  const PosteriorErrorBounds bounds = ErrorBounds(model, noise);
  for (int64_t q = m - 1; q >= 0; q -= kStep) {
    double means, variances, probabilities;
    reference.Evaluate(ConstMatrixView<float>(&queries[2 * q], 1, 2), &means, &variances,
                       &probabilities);
    ASSERT_NEAR(mean[q], means, bounds.mean) << q;
    ASSERT_NEAR(variance[q], variances, bounds.variance) << q;
    ASSERT_NEAR(probability[q], probabilities, bounds.probability) << q;
  }
}

// A posterior on several devices: every query's result is that of one of them.

std::shared_ptr<Context> Open(const char* device) { return Value(OpenContext({.device = device})); }

class SharedPosteriorTest : public testing::Test {
 protected:
  void SetUp() override {
    if (TestIsOnReference()) GTEST_SKIP() << "there is one device alone";
    problem_ = MakeProblem(random_, ArcsineParameters({1, 2, 3}), 30, 0.3);
  }
  std::unique_ptr<DensePosterior> Make(const std::vector<std::shared_ptr<Context>>& contexts) {
    return Value(CreateSharedPosterior(contexts, problem_.model(FactorKind::kCholesky)));
  }

  std::mt19937_64 random_ = TestRandom();
  Problem problem_;
};

// The first piece of each device is its own; which one computes the others is open.
TEST_F(SharedPosteriorTest, EveryDeviceHasItsPart) {
  const std::shared_ptr<Context> reference = Open("reference");
  const auto device = Make({TestContext()}), host = Make({reference}),
             shared = Make({TestContext(), reference});
  constexpr int64_t kQueries = 5 * 1024 + 17;
  const int64_t piece = SharedPiece(kQueries, 2);
  ASSERT_EQ(piece, 1024);
  const std::vector<float> queries = RandomQueries(random_, kQueries, 2);
  const ConstMatrixView<float> view(queries.data(), kQueries, 2);
  const std::vector<double> wide(queries.begin(), queries.end());
  Results of_device(kQueries), of_host(kQueries), of_both(kQueries), of_wide(kQueries);
  ASSERT_TRUE(device->Evaluate(view, of_device.outputs()).ok());
  ASSERT_TRUE(host->Evaluate(view, of_host.outputs()).ok());
  ASSERT_TRUE(shared->Evaluate(view, of_both.outputs()).ok());
  ASSERT_TRUE(shared->Evaluate({wide.data(), kQueries, 2}, of_wide.outputs()).ok());
  EXPECT_TRUE(of_both.guards_intact());
  int64_t different = 0;
  for (int64_t q = 0; q < kQueries; ++q) {
    const auto are = [&](const Results& found, const Results& one) {
      return found.mean(0, q) == one.mean(0, q) && found.variance(0, q) == one.variance(0, q) &&
             found.probability(0, q) == one.probability(0, q);
    };
    for (const Results* found : {&of_both, &of_wide}) {
      ASSERT_TRUE(are(*found, of_device) || are(*found, of_host)) << q;
      if (q < piece) {
        ASSERT_TRUE(are(*found, of_device)) << q;
      }
      if (q >= piece && q < 2 * piece) {
        ASSERT_TRUE(are(*found, of_host)) << q;
        different += are(*found, of_device) ? 0 : 1;
      }
    }
  }
  EXPECT_GT(different, 0);  // or the test could not tell them apart
}

TEST_F(SharedPosteriorTest, NothingIsWrittenWhereOneDeviceFails) {
  const auto shared = Make({TestContext(), Open("")});
  constexpr int64_t kQueries = 6000;
  const std::vector<float> queries = RandomQueries(random_, kQueries, 2);
  for (const int nth : {0, 1, 4}) {
    Results results(kQueries);
    FailCall("clEnqueueNDRangeKernel", nth, CL_OUT_OF_RESOURCES);
    const auto counts = shared->Evaluate({queries.data(), kQueries, 2}, results.outputs());
    EXPECT_TRUE(CallHasFailed());
    EXPECT_EQ(counts.status().code(), absl::StatusCode::kResourceExhausted);
    EXPECT_TRUE(results.mean.untouched() && results.variance.untouched());
  }
  Results results(kQueries);
  EXPECT_TRUE(shared->Evaluate({queries.data(), kQueries, 2}, results.outputs()).ok());
}

TEST_F(SharedPosteriorTest, RefusesWhatOneDeviceWould) {
  EXPECT_THAT(CreateSharedPosterior({}, problem_.model(FactorKind::kCholesky)), IsInvalid());
  EXPECT_THAT(
      CreateSharedPosterior({TestContext(), nullptr}, problem_.model(FactorKind::kCholesky)),
      IsInvalid());
  const auto shared = Make({TestContext(), TestContext()});
  EXPECT_EQ(shared->Enqueue({}, {}, {}).status().code(), absl::StatusCode::kFailedPrecondition);
  // On one device a posterior takes queues.
  const auto alone =
      Value(DensePosterior::Create(TestContext(), problem_.model(FactorKind::kCholesky)));
  EXPECT_EQ(Make({TestContext()})->Enqueue({}, {}, {}).status(),
            alone->Enqueue({}, {}, {}).status());
  constexpr int64_t kQueries = 3000;
  std::vector<float> queries = RandomQueries(random_, kQueries, 2);
  queries[2 * 2500] = std::numeric_limits<float>::quiet_NaN();
  Results results(kQueries);
  const absl::Status refused =
      shared->Evaluate({queries.data(), kQueries, 2}, results.outputs()).status();
  EXPECT_THAT(refused, IsInvalid());
  EXPECT_THAT(refused.ToString(), testing::HasSubstr("2500"));
  EXPECT_TRUE(results.mean.untouched());
  EXPECT_TRUE(shared->Evaluate({queries.data(), 0, 2}, results.outputs()).ok());
}

}  // namespace
}  // namespace egosieve::kernels
