// The work of one frame on a model of n points, stage by stage: adding k points, removing k points,
// calibration on a sample, one training step on 800 points, a posterior for the dense map.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdlib>
#include <numeric>
#include <utility>
#include <vector>

#include "bench/gp/street_points.h"
#include "gp/model/exact_model.h"
#include "gp/training/marginal_likelihood.h"

namespace egosieve::gp {
namespace {

using Clock = std::chrono::steady_clock;

void BM_OnlineFrame(benchmark::State& state) {
  const int64_t n = state.range(0), k = state.range(1);
  const Hyperparameters theta = DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, 6);
  auto model = ExactModel::Create(BenchContext(), theta);
  const StreetPoints start = MakeStreetPoints(n, 1);
  if (!model.ok() || !model->Add(start.view(), start.labels, 0).ok()) std::abort();
  const StreetPoints subset = MakeStreetPoints(800, 2);
  const std::vector<double> subset_targets = subset.targets();
  std::vector<int64_t> oldest(k);
  std::iota(oldest.begin(), oldest.end(), int64_t{0});
  std::vector<std::pair<const char*, double>> stages = {
      {"add_ms", 0}, {"remove_ms", 0}, {"calibrate_ms", 0}, {"train_ms", 0}, {"posterior_ms", 0}};
  int64_t frame = 1;
  for (auto _ : state) {
    state.PauseTiming();
    const StreetPoints fresh = MakeStreetPoints(k, 100 + frame);
    state.ResumeTiming();
    std::vector<Clock::time_point> marks = {Clock::now()};
    const auto mark = [&](bool ok) {
      if (!ok) std::abort();
      marks.push_back(Clock::now());
    };
    mark(model->Add(fresh.view(), fresh.labels, frame++).ok());
    mark(model->Remove(oldest).ok());
    const std::vector<int64_t> rows = StratifiedSample(model->targets(), 1000, 0.25, frame);
    const auto left_out = model->PredictLeaveOneOut(rows);
    std::vector<double> labels;
    for (const int64_t row : rows) labels.push_back(0.5 * (model->targets()[row] + 1.0));
    const auto fit = FitSquash(left_out->mean, left_out->LatentVariance(theta.noise_variance()),
                               labels, {1.0, 0.0});
    mark(fit.ok());
    mark(ComputeMarginalLikelihood(*BenchContext(), theta, {subset.view(), subset_targets},
                                   LikelihoodOrder::kValueAndGradient)
             .ok());
    mark(model->MakePosterior(*fit).ok());
    for (size_t s = 0; s < stages.size(); ++s) {
      stages[s].second +=
          std::chrono::duration<double, std::milli>(marks[s + 1] - marks[s]).count();
    }
  }
  for (const auto& [name, total] : stages) {
    state.counters[name] = benchmark::Counter(total, benchmark::Counter::kAvgIterations);
  }
}

BENCHMARK(BM_OnlineFrame)
    ->ArgNames({"n", "k"})
    ->Args({4000, 300})
    ->Args({1500, 300})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace egosieve::gp
