// The box means at every pixel and at every fifth pixel of an image with the size of a
// driving data set's.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "bench/kernels/benchmark_data.h"
#include "bench/kernels/roofline.h"
#include "kernels/ops/box_means.h"
#include "kernels/reference/image.h"

namespace egosieve::kernels {
namespace {

void BM_BoxMeans(benchmark::State& state) {
  const auto context = BenchmarkContext();
  const int width = 1242;
  const int height = 375;
  std::mt19937_64 random(1);
  std::vector<uint8_t> pixels(width * height * 3);
  for (uint8_t& pixel : pixels) pixel = static_cast<uint8_t>(random());
  const ImageView image = {pixels.data(), width, height, 3, width * 3};
  const ImageGrid grid = {width, height, static_cast<int>(state.range(0))};
  std::vector<float> out(grid.size() * kBoxMeanColumns);
  const MatrixView<float> view(out.data(), grid.size(), kBoxMeanColumns);
  const double copy = CopyBytesPerSecond();
  // The first call compiles.
  (void)BoxMeansOnGrid(*context, image, grid, {}, view);
  const LoopTimer timer;
  for (auto _ : state) {
    const absl::Status status = BoxMeansOnGrid(*context, image, grid, {}, view);
    if (!status.ok()) return state.SkipWithError(status.ToString().c_str());
  }
  const double seconds = timer.SecondsPerIteration(state.iterations());
  std::vector<float> expected(out.size());
  reference::BoxMeansOnGrid(image, grid, 7,
                            MatrixView<float>(expected.data(), grid.size(), kBoxMeanColumns));
  for (size_t i = 0; i < out.size(); ++i) {
    if (!(std::abs(out[i] - expected[i]) <= 1e-6)) return state.SkipWithError("wrong box means");
  }
  const double bytes = static_cast<double>(pixels.size() + out.size() * sizeof(float));
  state.counters["points_per_second"] = benchmark::Counter(
      static_cast<double>(grid.size()), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["fraction_of_copy_bandwidth"] = bytes / copy / seconds;
  state.counters["copy_bytes_per_second"] = copy;
}
BENCHMARK(BM_BoxMeans)
    ->Name("BM_BoxMeans/1242x375")
    ->ArgName("stride")
    ->Arg(1)
    ->Arg(5)
    ->Apply(TakeBothClocks);

}  // namespace
}  // namespace egosieve::kernels
