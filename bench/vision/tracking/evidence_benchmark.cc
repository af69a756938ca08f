// Tracks and evidence of one frame with n features: chaining matches, and fusing all terms.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <vector>

#include "tests/vision/evidence/point_street.h"
#include "vision/evidence/evidence_accumulator.h"
#include "vision/tracking/grid_tracker.h"

namespace egosieve::vision {
namespace {

constexpr int kFrames = 8, kGap = 2;

void BM_GridTracker(benchmark::State& state) {
  const cv::Size size(1242, 375);
  std::vector<PointPair> links;
  for (int y = 2; y < size.height; y += 5) {
    for (int x = 2; x < size.width; x += 5) {
      links.push_back({0.97 * (x - 600) + 600, 0.97 * (y - 180) + 180, static_cast<double>(x),
                       static_cast<double>(y)});
    }
  }
  auto tracker = GridTracker::Create({});
  int64_t frame = 0;
  for (auto _ : state) {
    if (!tracker->Advance(frame++, size, links).ok()) std::abort();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(links.size()));
}
BENCHMARK(BM_GridTracker)->Unit(benchmark::kMillisecond);

void BM_Evidence(benchmark::State& state) {
  StreetOptions options;
  options.static_count = static_cast<int>(state.range(0)) * 9 / 10;
  options.mover_count = static_cast<int>(state.range(0)) / 10;
  options.noise_pixels = 0.2;
  options.travel = {0.0, 0.0, 0.2};  // slow: most points stay in view
  options.mover_travel = {0.05, 0.0, 0.3};
  const PointStreet street(options);
  std::vector<EvidenceFrame> frames;
  for (int t = 0; t < kFrames; ++t) {
    EvidenceFrame frame;
    frame.gap = kGap;
    frame.size = options.size;
    if (t >= kGap) {
      frame.motion_model = MotionModelKind::kFundamental;
      frame.motion_matrix = street.Fundamental(t - kGap, t);
    }
    for (const Track& track : street.Tracks(t)) frame.points.push_back(PointOfTrack(track, kGap));
    frames.push_back(frame);
  }
  auto accumulator = EvidenceAccumulator::Create({});
  int64_t index = 0;
  for (const EvidenceFrame& first : frames) {
    EvidenceFrame frame = first;
    frame.index = index++;
    if (!accumulator->Add(frame).ok()) std::abort();
  }
  EvidenceFrame last = frames.back();
  bool has_pose = true;
  for (auto _ : state) {
    last.index = index++;
    const auto result = accumulator->Add(last);
    has_pose = has_pose && result.ok() && result->pose == PoseOutcome::kFound;
  }
  if (!has_pose) std::abort();
  state.counters["points"] = static_cast<double>(last.points.size());
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(last.points.size()));
}
BENCHMARK(BM_Evidence)->Arg(8500)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace egosieve::vision
