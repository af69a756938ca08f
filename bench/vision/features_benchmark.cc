// SIFT key points and corners, 7000 in a picture of 1242 x 375; OpenCV's SIFT on the same picture;
// the flow that tracks a grid.
#include <benchmark/benchmark.h>

#include <opencv2/features2d.hpp>

#include "bench/vision/textured_pair.h"
#include "vision/features/flow_grid.h"
#include "vision/paper/feature_extractor.h"

namespace egosieve::vision {
namespace {

void BM_Features(benchmark::State& state) {
  const auto threads = static_cast<int>(state.range(0));
  absl::StatusOr<FeatureSet> features = absl::UnknownError("");
  for (auto _ : state) features = ExtractFeatures(BenchmarkPair().first, threads);
  if (!features.ok()) return state.SkipWithError(features.status().ToString().c_str());
  const auto again = ExtractFeatures(BenchmarkPair().first, 1);
  if (again->descriptors != features->descriptors) return state.SkipWithError("not deterministic");
  if (features->size() != 7000) return state.SkipWithError("not the number asked for");
  state.counters["features"] = static_cast<double>(features->size());
}
BENCHMARK(BM_Features)->ArgName("threads")->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

void BM_FeaturesOpenCv(benchmark::State& state) {
  const auto sift = cv::SIFT::create(7000, 3, 0.01);
  std::vector<cv::KeyPoint> key_points;
  cv::Mat descriptors;
  for (auto _ : state) {
    sift->detectAndCompute(BenchmarkPair().first, cv::noArray(), key_points, descriptors);
  }
  state.counters["features"] = static_cast<double>(key_points.size());
}
BENCHMARK(BM_FeaturesOpenCv)->UseRealTime()->Unit(benchmark::kMillisecond);

void BM_FlowGrid(benchmark::State& state) {
  const TexturedPair& pair = BenchmarkPair();
  const FlowGridOptions options;
  TrackedGrid grid;
  for (auto _ : state) {
    const auto flow = ComputeFlow(pair.first, pair.second, options.quality);
    if (!flow.ok()) return state.SkipWithError(flow.status().ToString().c_str());
    grid = TrackGrid(*flow, pair.first, pair.second, true, options);
  }
  if (grid.agreeing_count < grid.point_count / 2) return state.SkipWithError("flow was lost");
  state.counters["points"] = static_cast<double>(grid.pairs.size());
}
BENCHMARK(BM_FlowGrid)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace egosieve::vision
