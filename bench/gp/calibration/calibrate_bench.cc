// Calibration given the factor: leave-one-out predictions of all points (m = n) or of a sample of
// m, and the fit of the squashing function.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <vector>

#include "bench/gp/street_points.h"
#include "gp/model/exact_model.h"

namespace egosieve::gp {
namespace {

void BM_Calibrate(benchmark::State& state) {
  const StreetPoints points = MakeStreetPoints(state.range(0), 1);
  auto model = ExactModel::Create(BenchContext(),
                                  DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, 6));
  if (!model.ok() || !model->Add(points.view(), points.labels, 0).ok()) std::abort();
  const std::vector<int64_t> rows = StratifiedSample(model->targets(), state.range(1), 0.25, 1);
  std::vector<double> labels;
  for (const int64_t row : rows) labels.push_back(points.labels[row]);
  for (auto _ : state) {
    const auto left_out = model->PredictLeaveOneOut(rows);
    if (!left_out.ok()) std::abort();
    const auto fit = FitSquash(left_out->mean,
                               left_out->LatentVariance(model->hyperparameters().noise_variance()),
                               labels, {1.0, 0.0});
    if (!fit.ok()) std::abort();
    state.counters["a"] = fit->parameters.a;
    state.counters["b"] = fit->parameters.b;
  }
}

BENCHMARK(BM_Calibrate)
    ->ArgNames({"n", "m"})
    ->Args({4000, 4000})
    ->Args({4000, 1000})
    ->Args({4000, 500})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace egosieve::gp
