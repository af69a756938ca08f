// The plane sweep at every second pixel of a picture with the size of a driving data set's, for a
// camera that moves sideways (patches of one size) and one that moves ahead (patches that grow).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "bench/kernels/benchmark_data.h"
#include "bench/kernels/roofline.h"
#include "kernels/ops/plane_sweep.h"
#include "kernels/reference/plane_sweep.h"

namespace egosieve::kernels {
namespace {

constexpr int kWidth = 1242, kHeight = 375, kSteps = 16;

// Smooth, so that a rounding of a position hardly changes a level.
std::vector<uint8_t> Waves(double phase) {
  std::vector<uint8_t> pixels;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double wave = std::sin(0.31 * x + 0.07 * y + phase) + std::sin(0.05 * x - 0.23 * y);
      pixels.push_back(static_cast<uint8_t>(128.0 + 60.0 * wave));
    }
  }
  return pixels;
}

// Multiply-adds and additions of the lanes that count. A row between columns takes 2 per pixel, a
// row between rows, the difference and its sums 5.
double Operations(int radius, bool ahead) {
  const double side = 2 * radius + 1;
  const double rows = ahead ? 2 * side : side + 1;
  return side * (2 * rows + 5 * side);
}

void BM_PlaneSweep(benchmark::State& state) {
  const auto context = BenchmarkContext();
  const bool ahead = state.range(1) != 0;
  const std::vector<uint8_t> first = Waves(0.0), second = Waves(0.4);
  PlaneSweepInputs inputs;
  inputs.first = {first.data(), kWidth, kHeight, 1, kWidth};
  inputs.second = {second.data(), kWidth, kHeight, 1, kWidth};
  inputs.grid = {kWidth, kHeight, 2};
  inputs.homography = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  inputs.epipole = {ahead ? -0.5 * kWidth : 16.0, ahead ? -0.5 * kHeight : 0.0, ahead ? -1.0 : 0.0};
  inputs.patch_radius = static_cast<int>(state.range(0));
  for (int j = 0; j < kSteps; ++j) {
    const float w = static_cast<float>(j) / (ahead ? 3 * kSteps : kSteps);
    inputs.steps.push_back({w, ahead ? 1.0f / (1.0f - w) : 1.0f});
  }
  const int64_t places = inputs.grid.size();
  const std::vector<float> flow(places * 2, 1.25f);
  inputs.flow = {flow.data(), places, 2};
  std::vector<float> out(places * kSweepColumns);
  const MatrixView<float> view(out.data(), places, kSweepColumns);
  const double peak = FmaPerSecond<float>(*context);
  // The first call compiles.
  (void)PlaneSweep(*context, inputs, view);
  const LoopTimer timer;
  for (auto _ : state) {
    const absl::Status status = PlaneSweep(*context, inputs, view);
    if (!status.ok()) return state.SkipWithError(status.ToString().c_str());
  }
  const double seconds = timer.SecondsPerIteration(state.iterations());
  std::vector<float> expected(out.size());
  reference::PlaneSweep(inputs, {expected.data(), places, kSweepColumns});
  for (int64_t i = 0; i < places; ++i) {
    // Positions are within 0.003 pixels and levels change by 33 a pixel: 0.1 each.
    const double cost = expected[i * kSweepColumns + kStaticCost];
    const double error = std::abs(out[i * kSweepColumns + kStaticCost] - cost);
    if (error > 1.4 * std::sqrt(cost) + 4.0) return state.SkipWithError("wrong cost");
  }
  const double operations = places * (kSteps + 1) * Operations(inputs.patch_radius, ahead);
  state.counters["points_per_second"] = benchmark::Counter(
      static_cast<double>(places), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["fraction_of_fma_peak"] = peak > 0 ? operations / seconds / peak : 0.0;
  state.counters["fma_peak"] = peak;
}
BENCHMARK(BM_PlaneSweep)
    ->Name("BM_PlaneSweep/1242x375")
    ->ArgNames({"radius", "ahead"})
    ->ArgsProduct({{2, 3}, {0, 1}})
    ->Apply(TakeBothClocks);

}  // namespace
}  // namespace egosieve::kernels
