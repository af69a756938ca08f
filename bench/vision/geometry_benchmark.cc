// Fits both motion models to 7000 point pairs, of which a fifth are movers and a tenth false
// matches, and selects one.
#include <benchmark/benchmark.h>

#include "tests/vision/geometry/synthetic_pairs.h"
#include "vision/paper/motion_selection.h"

namespace egosieve::vision {
namespace {

void BM_Geometry(benchmark::State& state) {
  testing::SyntheticOptions scene;
  scene.motion = static_cast<testing::CameraMotion>(state.range(0));
  scene.count = 7000;
  scene.mover_share = 0.2;
  scene.outlier_share = 0.1;
  const testing::SyntheticPairs pairs = testing::MakeSyntheticPairs(scene);
  uint64_t seed = 1;
  absl::StatusOr<MotionModel> model = absl::UnknownError("");
  for (auto _ : state) {
    model = SelectMotion(pairs.pairs, ++seed);  // RANSAC's work depends on chance
  }
  const bool is_forward = scene.motion == testing::CameraMotion::kForward;
  const MotionModelKind expected =
      is_forward ? MotionModelKind::kFundamental : MotionModelKind::kHomography;
  if (!model.ok() || model->kind != expected) return state.SkipWithError("wrong model");
}
BENCHMARK(BM_Geometry)
    ->ArgName("motion")
    ->Arg(static_cast<int>(testing::CameraMotion::kForward))
    ->Arg(static_cast<int>(testing::CameraMotion::kRotation))
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace egosieve::vision
