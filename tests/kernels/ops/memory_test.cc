// What reaches the device: the model once, then the queries alone.
#include <sys/resource.h>

#include <CL/opencl.hpp>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <memory>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/ops/dense_posterior.h"
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
  DeviceOutputs outputs;
  outputs.mean = {results(), 0};
  outputs.variance = {results(), kQueries};
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

// n = 1000, a sparse-looking factor, queries by the hundred thousand: the n x M array of
// covariances would take 800 MB.
TEST(MemoryCap, TheWholeCovarianceIsNeverInMemory) {
  if (TestIsOnReference()) GTEST_SKIP() << "the reference has no cap, and its tiles are 64 queries";
  std::mt19937_64 random = TestRandom();
  const int64_t n = 1000;
  const int64_t m = 60000;
  DensePosteriorOptions options;
  options.memory_cap_bytes = int64_t{16} << 20;
  auto posterior = Value(MakeDiagonalPosterior(TestContext(), n, options));
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
  EXPECT_TRUE(std::isfinite(mean[m - 1]) && variance[m - 1] > 0.0f && probability[m - 1] > 0.0f);
}

}  // namespace
}  // namespace egosieve::kernels
