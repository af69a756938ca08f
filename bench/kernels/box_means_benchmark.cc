// The box means at every pixel and at every fifth pixel of an image with the size of a
// driving data set's.
#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "bench/kernels/benchmark_data.h"
#include "bench/kernels/roofline.h"
#include "vision/image/box_means.h"

namespace egosieve::kernels {
namespace {

void BM_BoxMeans(benchmark::State& state) {
  const int width = 1242;
  const int height = 375;
  std::mt19937_64 random(1);
  std::vector<uint8_t> pixels(width * height * 3);
  for (uint8_t& pixel : pixels) pixel = static_cast<uint8_t>(random());
  const vision::ImageView image = {pixels.data(), width, height, 3, width * 3};
  const vision::ImageGrid grid = {width, height, static_cast<int>(state.range(0))};
  std::vector<float> out;
  const double copy = CopyBytesPerSecond();
  const LoopTimer timer;
  for (auto _ : state) {
    out = vision::BoxMeansOnGrid(image, grid);
  }
  const double seconds = timer.SecondsPerIteration(state.iterations());
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
