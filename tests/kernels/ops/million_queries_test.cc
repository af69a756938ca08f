// The posterior of a large model at a million queries, with variances, in 1.5 GB of resident
// memory. Minutes of work, so it is run by hand:
//
//   bazel run //tests/kernels/ops:million_queries
//
// EGOSIEVE_QUERIES and EGOSIEVE_POINTS set other sizes than 1,000,000 queries and 10,000 points.
// Most of the memory is the float64 factor that the model is made from, n^2 * 8 bytes; the program
// prints its times and its peak, and compares a sample of the queries with the float64 reference.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <random>
#include <vector>

#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gtest/gtest.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/reference/dense_posterior.h"
#include "tests/kernels/test_data.h"

namespace egosieve::kernels {
namespace {

constexpr int64_t kDimension = 6;
constexpr int64_t kSample = 256;
constexpr double kNoiseStddev = 0.3;
constexpr int64_t kMemoryBytes = 1'500'000'000;

int64_t SizeOf(const char* variable, int64_t otherwise) {
  const char* text = std::getenv(variable);
  const int64_t size = text == nullptr ? 0 : std::atoll(text);
  return size > 0 ? size : otherwise;
}

int64_t PeakBytes() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return int64_t{usage.ru_maxrss} << 10;
}

// The wall's and the process's processor time of a piece of work, printed.
template <typename Work>
void Timed(const char* what, Work&& work) {
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t begin_clock = std::clock();
  work();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  std::printf("%-10s %8.1f s, %8.1f s of processor time, peak %.3f GB\n", what, seconds.count(),
              static_cast<double>(std::clock() - begin_clock) / CLOCKS_PER_SEC, 1e-9 * PeakBytes());
  std::fflush(stdout);
}

// Points in [-1, 1]^6, targets of +-1, the factor of their covariance with noise.
struct LargeModel {
  explicit LargeModel(std::mt19937_64& random, int64_t n)
      : inputs(RandomPoints(random, n, kDimension)), factor(n, n) {
    model.covariance = ArcsineParameters({1.0, 1.5, 2.0, 0.7, 1.0, 0.9, 1.1});
    model.inputs = ConstMatrixView<double>(inputs.data(), n, kDimension);
    for (int64_t i = 0; i < n; ++i) alpha.push_back(inputs[i * kDimension] > 0.1 ? 1.0 : -1.0);
    model.factor_kind = FactorKind::kCholesky;
    model.factor = factor.view();
  }

  absl::Status Factorize(Context& context) {
    absl::Status status =
        CovarianceMatrix<double>(context, model.covariance, model.inputs,
                                 kNoiseStddev * kNoiseStddev, Triangle::kLower, factor.view());
    if (!status.ok()) return status;
    const std::vector<double> floors(alpha.size(), 0.0);
    if (gp::FactorizeInParallel(factor.view(), floors) >= 0) {
      return absl::InternalError("not positive definite");
    }
    const MatrixView<double> right(alpha.data(), model.inputs.rows, 1);
    gp::SolveLower(factor.view(), right);
    gp::SolveLowerTransposed(factor.view(), right);
    model.alpha = alpha.data();
    return absl::OkStatus();
  }

  std::vector<double> inputs;
  std::vector<double> alpha;
  gp::AlignedMatrix factor;
  PosteriorModel model;
};

TEST(MillionQueries, FitInOneAndAHalfGigabytes) {
  if (TestIsOnReference()) GTEST_SKIP() << "hours on the reference";
  std::mt19937_64 random = TestRandom();
  const int64_t m = std::max(SizeOf("EGOSIEVE_QUERIES", 1000000), kSample);
  const int64_t n = SizeOf("EGOSIEVE_POINTS", 10000);
  LargeModel large(random, n);
  Timed("factorise", [&] { ASSERT_EQ(large.Factorize(*TestContext()), absl::OkStatus()); });
  absl::StatusOr<std::unique_ptr<DensePosterior>> posterior;
  Timed("upload", [&] { posterior = DensePosterior::Create(TestContext(), large.model); });
  ASSERT_TRUE(posterior.ok()) << posterior.status();
  std::vector<float> queries(m * kDimension);
  for (float& value : queries) value = static_cast<float>(Uniform(random, -1.0, 1.0));
  std::vector<float> mean(m), variance(m), probability(m);
  absl::StatusOr<PosteriorCounts> counts;
  Timed("evaluate", [&] {
    counts = (*posterior)
                 ->Evaluate(ConstMatrixView<float>(queries.data(), m, kDimension),
                            {mean.data(), variance.data(), probability.data()});
  });
  ASSERT_TRUE(counts.ok()) << counts.status();
  const int64_t peak = PeakBytes();  // before the reference copies the factor
  EXPECT_LT(peak, kMemoryBytes);

  std::vector<float> sample;
  for (int64_t s = 0; s < kSample; ++s) {
    const float* query = &queries[s * (m / kSample) * kDimension];
    sample.insert(sample.end(), query, query + kDimension);
  }
  std::vector<double> means(kSample), variances(kSample), probabilities(kSample);
  reference::DensePosterior(large.model)
      .Evaluate(ConstMatrixView<float>(sample.data(), kSample, kDimension), means.data(),
                variances.data(), probabilities.data());
  const PosteriorErrorBounds bounds = ErrorBounds(large.model, kNoiseStddev);
  double worst_variance = 0.0;
  for (int64_t s = 0; s < kSample; ++s) {
    const int64_t q = s * (m / kSample);
    ASSERT_NEAR(mean[q], means[s], bounds.mean) << "query " << q;
    ASSERT_NEAR(variance[q], variances[s], bounds.variance) << "query " << q;
    ASSERT_NEAR(probability[q], probabilities[s], bounds.probability) << "query " << q;
    worst_variance = std::max(worst_variance, std::abs(variance[q] - variances[s]));
  }
  std::printf(
      "%lld queries, %lld points: peak %.3f GB; %lld of the queries agree with float64, "
      "variances within %.1e (bound %.1e)\n",
      static_cast<long long>(m), static_cast<long long>(n), 1e-9 * peak,
      static_cast<long long>(kSample), worst_variance, bounds.variance);
}

}  // namespace
}  // namespace egosieve::kernels
