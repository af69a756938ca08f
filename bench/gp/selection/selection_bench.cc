// The selection of points in one frame: the four filters and the budget, for `new` points and a
// model of n, without the posterior evaluations that two of the filters need.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <numeric>
#include <vector>

#include "bench/gp/street_points.h"
#include "gp/selection/agreement_filter.h"
#include "gp/selection/budget.h"
#include "gp/selection/density_filter.h"

namespace egosieve::gp {
namespace {

std::vector<float> NoisyPredictions(const std::vector<double>& labels) {
  std::mt19937_64 generator(5);
  std::normal_distribution<double> normal;
  std::vector<float> predictions;
  for (const double label : labels) {
    predictions.push_back(static_cast<float>(label + 0.3 * normal(generator)));
  }
  return predictions;
}

void BM_Selection(benchmark::State& state) {
  const StreetPoints model = MakeStreetPoints(state.range(0), 1);
  const StreetPoints fresh = MakeStreetPoints(state.range(1), 2);
  const std::vector<float> fresh_predictions = NoisyPredictions(fresh.labels);
  const std::vector<float> model_predictions = NoisyPredictions(model.labels);
  std::vector<int64_t> births(model.labels.size());
  for (size_t i = 0; i < births.size(); ++i) births[i] = static_cast<int64_t>(i / 200);
  std::vector<int64_t> newest_first(births.size());
  std::iota(newest_first.rbegin(), newest_first.rend(), int64_t{0});
  BudgetOptions budget;
  budget.budget = state.range(0) * 9 / 10;
  for (auto _ : state) {
    const auto sparse = FilterByDensity(fresh.view(), fresh.labels, {0.08});
    const auto novel = FilterByNovelty(fresh.labels, fresh_predictions);
    const auto consistent = FilterByConsistency(model.labels, model_predictions);
    const auto thinned = FilterByDensity(model.view(), model.labels, {0.056}, newest_first);
    const auto decision = EnforceBudget(model.labels, births, 20, budget);
    if (!(sparse.ok() && novel.ok() && consistent.ok() && thinned.ok() && decision.ok())) {
      std::abort();
    }
    state.counters["kept_new"] = static_cast<double>(sparse->size());
    state.counters["kept_model"] = static_cast<double>(thinned->size());
  }
}

BENCHMARK(BM_Selection)
    ->ArgNames({"n", "new"})
    ->Args({4000, 7000})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace egosieve::gp
