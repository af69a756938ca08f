#include "kernels/ops/posterior_tiling.h"

#include <algorithm>
#include <numeric>

#include "absl/strings/str_cat.h"
#include "kernels/ops/kernel_options.h"

namespace egosieve::kernels::opencl {
namespace {

// Usual least number of queries per chunk, if there are as many and the limit allows it: enough
// that the start of a kernel costs little in comparison.
constexpr int64_t kUsualChunk = 65536;

// With local tiles a whole group is read column by column, so the panel is the group.
FactorBlocking BlockingOf(const KernelTuning& tuning) {
  const int group = tuning.panel * tuning.panels_per_group;
  return {tuning.local_tiles ? group : tuning.panel, group, tuning.depth};
}

int64_t RoundUp(int64_t count, int64_t multiple) {
  return (count + multiple - 1) / multiple * multiple;
}

// (1), in bytes.
int64_t StagedBytes(const KernelTuning& tuning, int64_t point_width) {
  const int64_t group = int64_t{tuning.panel} * tuning.panels_per_group;
  const int64_t queries = int64_t{tuning.width} * tuning.work_group / tuning.panels_per_group;
  const int64_t floats = std::max({group * (point_width + 1), tuning.depth * (group + queries),
                                   tuning.panels_per_group * queries});
  return floats * static_cast<int64_t>(sizeof(float));
}

// A divisor of panels_per_group remains a divisor of work_group. Tiles have twice the queries, of
// which fewer columns are staged at once where they would not fit.
KernelTuning WithSmallerBlocks(KernelTuning tuning, int64_t local_bytes) {
  const int panels = tuning.panels_per_group;
  tuning.panels_per_group = panels % 2 == 0 ? panels / 2 : 1;
  tuning.depth = std::gcd(tuning.depth, tuning.panel * tuning.panels_per_group);
  while (tuning.depth % 2 == 0 && StagedBytes(tuning, 0) > local_bytes) tuning.depth /= 2;
  return tuning;
}

}  // namespace

KernelTuning FitLocalMemory(const KernelTuning& tuning, int64_t point_width, int64_t local_bytes) {
  if (!tuning.local_tiles) return tuning;
  KernelTuning fitting = tuning;
  while (StagedBytes(fitting, point_width) > local_bytes) {
    const KernelTuning smaller = WithSmallerBlocks(fitting, local_bytes);
    if (smaller == fitting || !smaller.Validate().ok()) {
      KernelTuning scalar = DefaultTuning(1);
      scalar.work_group = 64;
      return scalar;
    }
    fitting = smaller;
  }
  return fitting;
}

int StagedPoints(int64_t point_width, int64_t local_bytes) {
  int points = 64;
  while (points > 1 &&
         points * (point_width + 1) * static_cast<int64_t>(sizeof(float)) > local_bytes)
    points /= 2;
  return points;
}

PosteriorShapes::PosteriorShapes(const Context& context, int64_t point_width)
    : tuning_(FitLocalMemory(context.tuning(), point_width, context.local_memory_bytes())),
      staged_points_(StagedPoints(point_width, context.local_memory_bytes())),
      blocking_(BlockingOf(tuning_)),
      point_width_(point_width) {}

std::string PosteriorShapes::BuildOptions(const Context& context, FactorKind kind) const {
  const int factor = kind == FactorKind::kNone ? 0 : kind == FactorKind::kCholesky ? 1 : 2;
  const std::string shared = absl::StrCat(kernels::BuildOptions<float>(context),
                                          " -DFACTOR=", factor, " -DPANEL=", tuning_.panel,
                                          " -DWIDTH=", Width(kind), " -DDEPTH=", tuning_.depth);
  if (tuning_.local_tiles) {
    return absl::StrCat(shared, " -DPOINT_SPACE=__local -DPANELS=", Panels(kind),
                        " -DCOLUMNS=", tuning_.work_group / Panels(kind),
                        " -DSTAGED_POINTS=", staged_points_);
  }
  return absl::StrCat(shared, " -DGROUP=", blocking_.group, " -DWORK_GROUP=", tuning_.work_group);
}

PosteriorTiling PosteriorShapes::Tile(const Context& context, FactorKind kind, int64_t count,
                                      int64_t query_count, int64_t cap_bytes) const {
  const int64_t rows = kind == FactorKind::kNone ? 0 : PaddedCount(count, blocking_.panel);
  // Without local tiles a tile's sums are stored beside it.
  const int64_t micro_floats = (rows + (tuning_.local_tiles ? 0 : 2)) * MicroTileQueries(kind);
  // Prepared queries, also those of the next chunk, and the outputs.
  const int64_t query_floats = 2 * point_width_ + 3;
  const int64_t cap_floats = cap_bytes / static_cast<int64_t>(sizeof(float));
  const int tiles_per_group = tuning_.local_tiles ? 1 : tuning_.work_group;
  PosteriorTiling tiling;
  tiling.work_group = tuning_.work_group;
  tiling.micro_tiles = tuning_.local_tiles ? 1 : tuning_.micro_tiles;
  tiling.work_groups = std::max(context.info().compute_units, 1) * tuning_.groups_per_unit;
  // The minimum is a work-group of single micro-tiles.
  const auto scratch = [&] {
    return int64_t{tiling.micro_tiles} * tiling.work_groups * tiles_per_group * micro_floats;
  };
  while (tiling.micro_tiles > 1 && scratch() > cap_floats / 2) tiling.micro_tiles /= 2;
  while (tiling.work_groups > 1 && scratch() > cap_floats / 2) --tiling.work_groups;
  const int64_t tile = int64_t{tiling.micro_tiles} * MicroTileQueries(kind);
  const int64_t wave = tile * tiles_per_group * tiling.work_groups;
  int64_t most = std::min(RoundUp(kUsualChunk, wave), query_count);
  const int64_t fitting = cap_floats / 2 / query_floats;
  if (most > fitting) most = fitting >= wave ? fitting / wave * wave : fitting;
  tiling.chunk_queries = std::max<int64_t>(RoundUp(most, tile), tile);
  // Groups without a tile of their own would need scratch for nothing.
  tiling.work_groups =
      static_cast<int>(std::min<int64_t>(tiling.work_groups, (query_count + tile - 1) / tile));
  tiling.work_items = tiling.work_groups * tuning_.work_group;
  tiling.scratch_floats = tiling.micro_tiles * micro_floats;
  tiling.all_scratch_floats =
      std::max<int64_t>(tiling.scratch_floats * tiles_per_group * tiling.work_groups, 1);
  tiling.tile_queries = tile;
  return tiling;
}

}  // namespace egosieve::kernels::opencl
