// Dense posteriors over an image of 640 x 480 pixels. Each benchmark checks a sample of its results
// against the float64 reference outside the timer.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bench/kernels/benchmark_data.h"
#include "bench/kernels/roofline.h"
#include "kernels/base/prepared_points.h"
#include "kernels/covariance/arcsine.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/reference/dense_posterior.h"

namespace egosieve::kernels {
namespace {

// Vector operations (a multiply-add counts one) for one evaluation and its share of the mean, with
// 6 inputs.
//   squared exponential     12 distance, 1 half, 13 exponential, 1 alpha = 27
//   Matern 5/2              12 distance, 4 root, 1 sign, 2 factor, 13 exponential, 1 product,
//                           1 alpha = 34
// The arcsine, with 7 components:
//   from the dot product    8 dot product, 2 h, 4 root, 8 polynomial and product, 2 sign,
//                           1 alpha = 25
//   if differences are      1 comparison for all; if a vector of queries has a lane that needs
//   possible                them, 1 sign, 1 sum of e, 14 differences and squares, 1 selection = 17
constexpr double kSquaredExponentialOperations = 27;
constexpr double kMatern52Operations = 34;
constexpr double kDotOperations = 25;
constexpr double kComparison = 1;
constexpr double kDifferenceOperations = 17;

// Mean number of operations per evaluation. Of the arcsine the share of vectors that need
// differences is counted on a sample of vectors of 16 queries.
double OperationsPerEvaluation(const PosteriorModel& model, const std::vector<float>& queries) {
  const CovarianceFunction function = model.covariance.function;
  if (function == CovarianceFunction::kSquaredExponential) return kSquaredExponentialOperations;
  if (function != CovarianceFunction::kArcsine) return kMatern52Operations;
  const int64_t width = PreparedWidth(model.covariance);
  const double threshold = DifferenceThreshold(width - 1);
  std::vector<float> a(width);
  std::vector<float> b(width);
  int64_t vectors = 0;
  int64_t with_differences = 0;
  double smallest = 1.0;
  for (int64_t i = 0; i < model.inputs.rows; i += 17) {
    PointPreparation(model.covariance).Prepare(model.inputs.row(i), b.data(), 1);
    smallest = std::min<double>(smallest, b[width - 1]);
    for (size_t first = 0; first + 16 * 6 <= queries.size(); first += 16 * 6 * 101) {
      bool any = false;
      for (int lane = 0; lane < 16; ++lane) {
        PointPreparation(model.covariance).Prepare(&queries[first + lane * 6], a.data(), 1);
        float dot = 0.0f;
        for (int64_t c = 0; c + 1 < width; ++c) dot += a[c] * b[c];
        any = any || 0.5 - 2.0 * std::abs(dot) < threshold;
      }
      ++vectors;
      with_differences += any ? 1 : 0;
    }
  }
  if (smallest > threshold) return kDotOperations;
  return kDotOperations + kComparison +
         kDifferenceOperations * static_cast<double>(with_differences) /
             static_cast<double>(vectors);
}

// Compares a sample of queries with the reference and describes errors, in units of each output; ""
// if there are none.
std::string CheckSample(const PosteriorModel& model, const std::vector<float>& queries,
                        const float* mean, const float* variance, const float* probability) {
  // Fifteen times the error of the mean in bench/results/peers.md, for weights that cancel more.
  constexpr double kTolerance = 1e-3;
  constexpr int64_t kSample = 64;
  const int64_t dimension = model.covariance.input_dimension();
  const int64_t count = static_cast<int64_t>(queries.size()) / dimension;
  std::vector<float> chosen;
  std::vector<int64_t> rows;
  for (int64_t s = 0; s < kSample; ++s) {
    rows.push_back(s * (count - 1) / (kSample - 1));
    chosen.insert(chosen.end(), &queries[rows.back() * dimension],
                  &queries[rows.back() * dimension] + dimension);
  }
  std::vector<double> means(kSample), variances(kSample), probabilities(kSample);
  PosteriorModel checked = model;
  if (variance == nullptr) checked.factor_kind = FactorKind::kNone;
  reference::DensePosterior(checked).Evaluate(
      ConstMatrixView<float>(chosen.data(), kSample, dimension), means.data(),
      variance == nullptr ? nullptr : variances.data(),
      variance == nullptr ? nullptr : probabilities.data());
  double worst = 0.0;
  for (int64_t s = 0; s < kSample; ++s) {
    worst = std::max(worst, std::abs(mean[rows[s]] - means[s]));
    if (variance != nullptr) {
      worst = std::max(worst, std::abs(variance[rows[s]] - variances[s]));
      worst = std::max(worst, std::abs(probability[rows[s]] - probabilities[s]));
    }
  }
  return worst <= kTolerance ? "" : "off by " + std::to_string(worst);
}

void BM_DensePosteriorMean(benchmark::State& state, BenchmarkKernel kernel) {
  const auto context = BenchmarkContext();
  const int64_t n = state.range(0);
  const PosteriorModel model = ModelOf(n, kernel).model(FactorKind::kNone);
  const auto posterior = DensePosterior::Create(context, model);
  if (!posterior.ok()) return state.SkipWithError(posterior.status().ToString().c_str());
  const std::vector<float> queries = ImageQueries(1);
  const int64_t m = static_cast<int64_t>(queries.size()) / 6;
  std::vector<float> mean(m);
  const double peak = FmaPerSecond<float>(*context);
  // The first call compiles.
  (void)(*posterior)->Evaluate(ConstMatrixView<float>(queries.data(), 1, 6), {mean.data()});
  const LoopTimer timer;
  for (auto _ : state) {
    const auto counts =
        (*posterior)->Evaluate(ConstMatrixView<float>(queries.data(), m, 6), {mean.data()});
    if (!counts.ok()) return state.SkipWithError(counts.status().ToString().c_str());
  }
  const double seconds = timer.SecondsPerIteration(state.iterations());
  const std::string wrong = CheckSample(model, queries, mean.data(), nullptr, nullptr);
  if (!wrong.empty()) return state.SkipWithError(wrong.c_str());
  const double evaluations = static_cast<double>(m) * n;
  state.counters["evaluations_per_second"] =
      benchmark::Counter(evaluations, benchmark::Counter::kIsIterationInvariantRate);
  const double operations = OperationsPerEvaluation(model, queries);
  state.counters["operations_an_evaluation"] = operations;
  state.counters["fraction_of_fma_peak"] = evaluations * operations / peak / seconds;
  state.counters["fma_peak"] = peak;
}
BENCHMARK_CAPTURE(BM_DensePosteriorMean, arcsine, BenchmarkKernel::kSteepArcsine)
    ->ArgName("n")
    ->Arg(4000)
    ->Apply(TakeBothClocks);
BENCHMARK_CAPTURE(BM_DensePosteriorMean, arcsine_plain, BenchmarkKernel::kGentleArcsine)
    ->ArgName("n")
    ->Arg(4000)
    ->Apply(TakeBothClocks);

BENCHMARK_CAPTURE(BM_DensePosteriorMean, squared_exponential, BenchmarkKernel::kSquaredExponential)
    ->ArgName("n")
    ->Arg(4000)
    ->Apply(TakeBothClocks);
BENCHMARK_CAPTURE(BM_DensePosteriorMean, matern52, BenchmarkKernel::kMatern52)
    ->ArgName("n")
    ->Arg(4000)
    ->Apply(TakeBothClocks);

// Mean, variance and probability of every `stride`-th pixel.
void EvaluateAll(benchmark::State& state, const PosteriorModel& model, int stride,
                 double strsm_seconds) {
  const auto posterior = DensePosterior::Create(BenchmarkContext(), model);
  if (!posterior.ok()) return state.SkipWithError(posterior.status().ToString().c_str());
  const std::vector<float> queries = ImageQueries(stride);
  const int64_t m = static_cast<int64_t>(queries.size()) / 6;
  std::vector<float> mean(m), variance(m), probability(m);
  // The first call compiles.
  (void)(*posterior)
      ->Evaluate(ConstMatrixView<float>(queries.data(), 1, 6),
                 {mean.data(), variance.data(), probability.data()});
  const LoopTimer timer;
  for (auto _ : state) {
    const auto counts = (*posterior)
                            ->Evaluate(ConstMatrixView<float>(queries.data(), m, 6),
                                       {mean.data(), variance.data(), probability.data()});
    if (!counts.ok()) return state.SkipWithError(counts.status().ToString().c_str());
  }
  const double seconds = timer.SecondsPerIteration(state.iterations());
  const std::string wrong =
      CheckSample(model, queries, mean.data(), variance.data(), probability.data());
  if (!wrong.empty()) return state.SkipWithError(wrong.c_str());
  state.counters["queries_per_second"] =
      benchmark::Counter(static_cast<double>(m), benchmark::Counter::kIsIterationInvariantRate);
  const double n = static_cast<double>(model.inputs.rows);
  // n^2 / 2 multiply-adds per query, for the variance alone.
  state.counters["fraction_of_fma_peak"] =
      0.5 * n * n * m / FmaPerSecond<float>(*BenchmarkContext()) / seconds;
  state.counters["gflops"] =
      benchmark::Counter(1e-9 * n * n * m, benchmark::Counter::kIsIterationInvariantRate);
  if (strsm_seconds > 0.0) {
    state.counters["fraction_of_strsm"] = strsm_seconds / seconds;
    state.counters["strsm_gflops"] = 1e-9 * n * n * m / strsm_seconds;
  }
}

void BM_DensePosteriorVariance(benchmark::State& state, BenchmarkKernel kernel) {
  const int64_t n = state.range(0);
  const int64_t m = static_cast<int64_t>(ImageQueries(5).size()) / 6;
  static std::map<int64_t, double> strsm;
  if (strsm.count(n) == 0) strsm[n] = StrsmSeconds(n, m);
  EvaluateAll(state, ModelOf(n, kernel).model(FactorKind::kCholesky), 5, strsm[n]);
}
BENCHMARK_CAPTURE(BM_DensePosteriorVariance, arcsine, BenchmarkKernel::kSteepArcsine)
    ->ArgName("n")
    ->Arg(4000)
    ->Apply(TakeBothClocks);
BENCHMARK_CAPTURE(BM_DensePosteriorVariance, squared_exponential,
                  BenchmarkKernel::kSquaredExponential)
    ->ArgName("n")
    ->Arg(4000)
    ->Apply(TakeBothClocks);

// Exact mean, variance and probability of every pixel: enough work to fill a GPU.
void BM_DensePosteriorPicture(benchmark::State& state) {
  EvaluateAll(state,
              ModelOf(state.range(0), BenchmarkKernel::kSteepArcsine).model(FactorKind::kCholesky),
              1, 0.0);
  constexpr double kPixelsOfKitti = 1242.0 * 375.0;
  state.counters["kitti_pictures_per_second"] =
      benchmark::Counter(static_cast<double>(ImageQueries(1).size()) / 6.0 / kPixelsOfKitti,
                         benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_DensePosteriorPicture)
    ->Name("BM_DensePosteriorPicture/arcsine")
    ->ArgName("n")
    ->Arg(4000)
    ->Apply(TakeBothClocks);

// Threads that query one posterior at the same time, with too few queries per call for a second
// core, so that on two idle cores each of two threads has the rate of a single one.
void BM_DensePosteriorByThreads(benchmark::State& state) {
  static const std::unique_ptr<DensePosterior> posterior = [] {
    auto made = DensePosterior::Create(
        BenchmarkContext(),
        ModelOf(4000, BenchmarkKernel::kSteepArcsine).model(FactorKind::kCholesky));
    return made.ok() ? *std::move(made) : nullptr;
  }();
  if (posterior == nullptr) return state.SkipWithError("no posterior");
  constexpr int64_t kQueries = 48;
  const std::vector<float> queries = ImageQueries(5);
  std::vector<float> mean(kQueries), variance(kQueries);
  for (auto _ : state) {
    const auto counts = posterior->Evaluate(ConstMatrixView<float>(queries.data(), kQueries, 6),
                                            {mean.data(), variance.data()});
    if (!counts.ok()) return state.SkipWithError(counts.status().ToString().c_str());
  }
  // The iterations of this thread; those of a report are all threads'.
  state.counters["queries_per_second_and_thread"] =
      benchmark::Counter(static_cast<double>(kQueries * state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kAvgThreads);
}
BENCHMARK(BM_DensePosteriorByThreads)
    ->Threads(1)
    ->Threads(2)
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);

void BM_SparsePosterior(benchmark::State& state) {
  EvaluateAll(
      state,
      ModelOf(state.range(0), BenchmarkKernel::kSteepArcsine).model(FactorKind::kInverseCholesky),
      1, 0.0);
}
BENCHMARK(BM_SparsePosterior)
    ->Name("BM_SparsePosterior/arcsine")
    ->ArgName("m")
    ->Arg(256)
    ->Arg(512)
    ->Apply(TakeBothClocks);

// The work before the first query of a frame: checks, packing, upload.
void BM_DensePosteriorCreate(benchmark::State& state) {
  const PosteriorModel model =
      ModelOf(state.range(0), BenchmarkKernel::kSteepArcsine).model(FactorKind::kCholesky);
  for (auto _ : state) {
    const auto posterior = DensePosterior::Create(BenchmarkContext(), model);
    if (!posterior.ok()) return state.SkipWithError(posterior.status().ToString().c_str());
  }
}
BENCHMARK(BM_DensePosteriorCreate)
    ->Name("BM_DensePosteriorCreate/arcsine")
    ->ArgName("n")
    ->Arg(4000)
    ->Apply(TakeBothClocks);

}  // namespace
}  // namespace egosieve::kernels
