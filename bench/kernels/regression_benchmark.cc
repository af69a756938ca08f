// Exact regression on the device in float64: the factorisation with the solves, alone and with the
// inverse and the likelihood's gradient. Residuals are checked outside the timer.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "bench/kernels/benchmark_data.h"
#include "bench/kernels/roofline.h"
#include "kernels/ops/exact_regression.h"
#include "kernels/reference/covariance.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels {
namespace {

constexpr double kNoiseVariance = 0.09;

// The largest residual of (K + noise I) alpha = y in some of the rows.
double LargestResidual(const CovarianceParameters& parameters, ConstMatrixView<double> x,
                       const std::vector<double>& y, const std::vector<double>& alpha) {
  double largest = 0.0;
  for (int64_t i = 0; i < x.rows; i += 97) {
    double residual = kNoiseVariance * alpha[i] - y[i];
    for (int64_t j = 0; j < x.rows; ++j) {
      residual += reference::Covariance(parameters, x.row(i), x.row(j)) * alpha[j];
    }
    largest = std::isnan(residual) ? residual : std::max(largest, std::abs(residual));
  }
  return largest;
}

void BM_DeviceRegression(benchmark::State& state, bool with_gradient) {
  const auto context = BenchmarkContext();
  if (context->is_reference() || !context->info().float64) {
    return state.SkipWithError("the device has no float64");
  }
  const int64_t n = state.range(0);
  const std::vector<float> pixels = ImageQueries(5);
  std::mt19937_64 random(n);
  std::vector<double> points, y;
  for (int64_t i = 0; i < n; ++i) {
    const float* point = &pixels[random() % (pixels.size() / 6) * 6];
    points.insert(points.end(), point, point + 6);
    y.push_back(point[0] * point[0] + point[1] * point[1] < 0.25 ? 1.0 : -1.0);
  }
  const ConstMatrixView<double> x(points.data(), n, 6), targets(y.data(), n, 1);
  const CovarianceParameters parameters = BenchmarkCovariance(BenchmarkKernel::kSteepArcsine);
  const double peak = FmaPerSecond<double>(*context);
  const auto regress = [&] {
    return RegressOnDevice(*context, parameters, x, targets, kNoiseVariance, {}, with_gradient);
  };
  auto result = regress();  // the first call compiles
  const LoopTimer timer;
  for (auto _ : state) result = regress();
  const double seconds = timer.SecondsPerIteration(state.iterations());
  if (!result.ok()) return state.SkipWithError(result.status().ToString().c_str());
  // Backward stable: n eps |K| |alpha| is below 1e-7 here.
  if (!(LargestResidual(parameters, x, y, result->alpha) <= 1e-7)) {
    return state.SkipWithError("wrong solution");
  }
  // Multiply-adds: n^3 / 6 each for the factor, for its inverse and for the inverse's product.
  const double cube = static_cast<double>(n) * static_cast<double>(n) * static_cast<double>(n);
  const double operations = (with_gradient ? 3.0 : 1.0) * cube / 6.0;
  state.counters["gflops"] =
      benchmark::Counter(2e-9 * operations, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["fraction_of_fma_peak"] = operations / peak / seconds;
  state.SetLabel(context->info().name);
}
BENCHMARK_CAPTURE(BM_DeviceRegression, fit, false)
    ->ArgName("n")
    ->Arg(1000)
    ->Arg(4000)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_DeviceRegression, likelihood_gradient, true)
    ->ArgName("n")
    ->Arg(1000)
    ->Arg(4000)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace egosieve::kernels
