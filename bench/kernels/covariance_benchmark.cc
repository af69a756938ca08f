// Covariance matrices and gradients in float64, as the training uses them.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "bench/kernels/benchmark_data.h"
#include "bench/kernels/roofline.h"
#include "kernels/ops/covariance_matrix.h"
#include "kernels/reference/covariance.h"

namespace egosieve::kernels {
namespace {

// Only points; the factor of ModelOf is not needed.
std::vector<double> Points(int64_t n) {
  const std::vector<float> queries = ImageQueries(5);
  std::vector<double> points;
  for (int64_t i = 0; i < n; ++i) {
    const int64_t row = i * 7919 % (static_cast<int64_t>(queries.size()) / 6);
    points.insert(points.end(), &queries[row * 6], &queries[row * 6] + 6);
  }
  return points;
}

template <BenchmarkKernel kernel>
void BM_CovarianceMatrix(benchmark::State& state) {
  const auto context = BenchmarkContext();
  const int64_t n = state.range(0);
  const std::vector<double> points = Points(n);
  const ConstMatrixView<double> x(points.data(), n, 6);
  const CovarianceParameters parameters = BenchmarkCovariance(kernel);
  std::vector<double> out(n * n);
  const MatrixView<double> view(out.data(), n, n);
  const double copy = CopyBytesPerSecond();
  // The first call compiles.
  (void)CovarianceMatrix(*context, parameters, x, 0.09, Triangle::kLower, view);
  const LoopTimer timer;
  for (auto _ : state) {
    const absl::Status status =
        CovarianceMatrix(*context, parameters, x, 0.09, Triangle::kLower, view);
    if (!status.ok()) return state.SkipWithError(status.ToString().c_str());
  }
  const double seconds = timer.SecondsPerIteration(state.iterations());
  for (int64_t i = 0; i < n; i += 97) {
    for (int64_t j = 0; j <= i; j += 89) {
      const double expected =
          reference::Covariance(parameters, x.row(i), x.row(j)) + (i == j ? 0.09 : 0.0);
      if (!(std::abs(view(i, j) - expected) <= 2e-6)) return state.SkipWithError("wrong element");
    }
  }
  const double elements = 0.5 * n * (n + 1);
  state.counters["evaluations_per_second"] =
      benchmark::Counter(elements, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["fraction_of_copy_bandwidth"] = elements * sizeof(double) / copy / seconds;
  state.counters["copy_bytes_per_second"] = copy;
}
BENCHMARK_TEMPLATE(BM_CovarianceMatrix, BenchmarkKernel::kSteepArcsine)
    ->Name("BM_CovarianceMatrix/arcsine")
    ->ArgName("n")
    ->Arg(800)
    ->Arg(4000)
    ->Apply(TakeBothClocks);
BENCHMARK_TEMPLATE(BM_CovarianceMatrix, BenchmarkKernel::kSquaredExponential)
    ->Name("BM_CovarianceMatrix/squared_exponential")
    ->ArgName("n")
    ->Arg(4000)
    ->Apply(TakeBothClocks);
// Vector operations per pair, 7 components: 38 for the covariance (double: 11 more in the
// polynomial, the square root counts 5), 8 for the factor, 4 for each component.
constexpr double kGradientOperations = 38 + 11 + 8 + 28;

void BM_CovarianceGradient(benchmark::State& state) {
  const auto context = BenchmarkContext();
  const int64_t n = state.range(0);
  const std::vector<double> points = Points(n);
  const ConstMatrixView<double> x(points.data(), n, 6);
  const CovarianceParameters parameters = BenchmarkCovariance(BenchmarkKernel::kSteepArcsine);
  std::vector<double> w(n * n);
  for (int64_t i = 0; i < n * n; ++i)
    w[i] = 1e-3 * static_cast<double>(i * 2654435761 % 2001 - 1000);
  const ConstMatrixView<double> weights(w.data(), n, n);
  std::vector<double> gradient;
  const double peak = FmaPerSecond<double>(*context);
  // The first call compiles.
  (void)CovarianceGradient(*context, parameters, x, weights);
  const LoopTimer timer;
  for (auto _ : state) {
    const auto result = CovarianceGradient(*context, parameters, x, weights);
    if (!result.ok()) return state.SkipWithError(result.status().ToString().c_str());
    gradient = *result;
  }
  const double seconds = timer.SecondsPerIteration(state.iterations());
  const std::vector<double> expected =
      reference::CovarianceGradient(parameters, x, x, weights, true);
  for (size_t t = 0; t < expected.size(); ++t) {
    if (!(std::abs(gradient[t] - expected[t]) <= 1e-12 * n * n))
      return state.SkipWithError("wrong gradient");
  }
  const double pairs = 0.5 * n * (n + 1);
  state.counters["pairs_per_second"] =
      benchmark::Counter(pairs, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["fraction_of_fma_peak"] = pairs * kGradientOperations / peak / seconds;
}
BENCHMARK(BM_CovarianceGradient)
    ->Name("BM_CovarianceGradient/arcsine")
    ->ArgName("n")
    ->Arg(800)
    ->Arg(2000)
    ->Apply(TakeBothClocks);

}  // namespace
}  // namespace egosieve::kernels
