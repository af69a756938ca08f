// Memory that an evaluation takes: bounded by the cap, whatever the number of queries.
#include <sys/resource.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <vector>

#include "gtest/gtest.h"
#include "kernels/ops/dense_posterior.h"
#include "tests/kernels/ops/posterior_test.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {
namespace {

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
