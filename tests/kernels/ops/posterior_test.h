// What the tests of the dense posterior share: guarded results, and the shapes of the kernels that
// each test runs with.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/context.h"
#include "tests/kernels/test_data.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {

struct Results {
  GuardedMatrix<float> mean, variance, probability;
  explicit Results(int64_t m) : mean(1, m), variance(1, m), probability(1, m) {}
  PosteriorOutputs outputs() { return {mean.data(), variance.data(), probability.data()}; }
  bool guards_intact() const {
    return mean.guards_intact() && variance.guards_intact() && probability.guards_intact();
  }
};

inline void ExpectSame(const Results& actual, const Results& expected, int64_t m,
                       int64_t first = 0) {
  EXPECT_TRUE(actual.guards_intact());
  for (int64_t q = 0; q < m; ++q) {
    ASSERT_EQ(actual.mean(0, q), expected.mean(0, first + q)) << q;
    ASSERT_EQ(actual.variance(0, q), expected.variance(0, first + q)) << q;
    ASSERT_EQ(actual.probability(0, q), expected.probability(0, first + q)) << q;
  }
}

inline std::vector<float> RandomQueries(std::mt19937_64& random, int64_t m, int64_t dimension) {
  std::vector<float> queries(m * dimension);
  for (float& value : queries) value = static_cast<float>(Uniform(random, -1.0, 1.0));
  return queries;
}

// A posterior of n points whose factor is 100 I.
inline absl::StatusOr<std::unique_ptr<DensePosterior>> MakeDiagonalPosterior(
    std::shared_ptr<Context> context, int64_t n, const DensePosteriorOptions& options = {},
    const CovarianceParameters& covariance = ArcsineParameters({1, 2, 3})) {
  std::mt19937_64 random = TestRandom();
  const int64_t dimension = covariance.input_dimension();
  const std::vector<double> inputs = RandomPoints(random, n, dimension),
                            alpha = RandomPoints(random, n, 1);
  std::vector<double> factor(n * n, 0.0);
  for (int64_t i = 0; i < n; ++i) factor[i * n + i] = 100.0;
  const PosteriorModel model{.covariance = covariance,
                             .inputs = ConstMatrixView<double>(inputs.data(), n, dimension),
                             .alpha = alpha.data(),
                             .factor_kind = FactorKind::kCholesky,
                             .factor = ConstMatrixView<double>(factor.data(), n, n)};
  return DensePosterior::Create(std::move(context), model, options);
}

// Whether the tests run with the device's own shapes; with the tiles in local memory that GPUs
// take, small ones, so that every size is around some block of theirs; or with copies of all
// arrays, as devices with memory of their own need them.
enum class Shapes { kOfTheDevice, kLocalTiles, kOwnMemory };

inline std::string NameOf(const testing::TestParamInfo<Shapes>& info) {
  return info.param == Shapes::kLocalTiles  ? "LocalTiles"
         : info.param == Shapes::kOwnMemory ? "OwnMemory"
                                            : "OfTheDevice";
}

inline KernelTuning SmallLocalTiles() {
  KernelTuning tuning = DefaultGpuTuning();
  tuning.panel = 2;
  tuning.panels_per_group = 8;
  tuning.depth = 8;
  tuning.width = 2;
  tuning.mean_width = 1;
  tuning.work_group = 32;
  return tuning;
}

inline std::shared_ptr<Context> OpenLocalTiles() {
  static const std::shared_ptr<Context> context = Value(OpenContext({.tuning = SmallLocalTiles()}));
  return context;
}

// With so little local memory that points of 96 values do not fit in blocks of these sizes.
inline std::shared_ptr<Context> OpenLittleLocalMemory(int64_t bytes) {
  return Value(OpenContext({.local_memory_bytes = bytes, .tuning = SmallLocalTiles()}));
}

// 32 inputs, 96 values per prepared point.
inline CovarianceParameters WideParameters() {
  CovarianceParameters parameters{.function = Value(CovarianceFunction::Parse("periodic"))};
  parameters.scales.assign(64, 6.0);                     // lengths
  std::fill_n(parameters.scales.begin() + 32, 32, 3.0);  // periods
  return parameters;
}

inline std::shared_ptr<Context> OpenOwnMemory() {
  static const std::shared_ptr<Context> context = Value(OpenContext({.shared_memory = false}));
  return context;
}

class PosteriorTest : public testing::TestWithParam<Shapes> {
 protected:
  void SetUp() override {
    if (GetParam() != Shapes::kOfTheDevice && TestIsOnReference()) {
      GTEST_SKIP() << "the reference has no shapes";
    }
  }
  std::shared_ptr<Context> context() const {
    return GetParam() == Shapes::kLocalTiles  ? OpenLocalTiles()
           : GetParam() == Shapes::kOwnMemory ? OpenOwnMemory()
                                              : TestContext();
  }

  std::mt19937_64 random_ = TestRandom();
};

}  // namespace egosieve::kernels
