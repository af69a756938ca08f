// The log marginal likelihood and its gradient with respect to all eight hyperparameters, in
// float64.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <vector>

#include "bench/gp/street_points.h"
#include "gp/training/marginal_likelihood.h"

namespace egosieve::gp {
namespace {

void BM_LikelihoodAndGradient(benchmark::State& state) {
  const StreetPoints points = MakeStreetPoints(state.range(0), 1);
  const std::vector<double> targets = points.targets();
  const Hyperparameters theta = DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, 6);
  for (auto _ : state) {
    const auto result = ComputeMarginalLikelihood(*BenchContext(), theta, {points.view(), targets},
                                                  LikelihoodOrder::kValueAndGradient);
    if (!result.ok()) std::abort();
    benchmark::DoNotOptimize(result->value);
  }
  const double n = static_cast<double>(state.range(0));
  // Factor, inverse of the factor, inverse: n^3 / 3 each.
  state.counters["flops"] =
      benchmark::Counter(n * n * n, benchmark::Counter::kIsIterationInvariantRate);
}

BENCHMARK(BM_LikelihoodAndGradient)
    ->ArgName("n")
    ->Arg(800)
    ->Arg(2000)
    ->Arg(4000)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace egosieve::gp
