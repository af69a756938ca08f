// Division of a dense posterior's queries into tiles, work-groups and chunks, with the
// corresponding build options, also for points that are wide in comparison with the device's local
// memory.
//
// With P values per prepared point, a block of G = panel panels_per_group rows and a tile of Q =
// width work_group / panels_per_group queries, a work-group of kernels/cl/dense_posterior_local.cl
// stages, in floats,
//
//   (1) with a factor     max(G P, depth (G + Q), panels_per_group Q)
//   (2) the mean alone    S (P + 1), S points
//
// Smaller blocks read the factor's tile more often: 4 / G bytes of scratch per multiply-add.
#pragma once

#include <cstdint>
#include <string>

#include "kernels/base/posterior_model.h"
#include "kernels/ops/opencl_posterior_model.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

// `tuning` if it has no local tiles or (1) fits in local_bytes; else with panels_per_group halved
// until it fits, and a depth that divides G. If no valid shape fits, DefaultTuning(1) with 64
// work-items side by side, which needs no local memory. In (1) G P is taken as G (P + 1), since a
// driver may need some of the memory.
KernelTuning FitLocalMemory(const KernelTuning& tuning, int64_t point_width, int64_t local_bytes);

// S of (2): 64, SUM_BLOCK of kernels/cl/posterior_outputs.cl, halved until (2) fits.
int StagedPoints(int64_t point_width, int64_t local_bytes);

// Sizes within the memory limit.
struct PosteriorTiling {
  int micro_tiles = 1;
  int work_groups = 1;
  int work_items = 1;
  int work_group = 1;
  int64_t scratch_floats = 0;  // per tile, which is a work-item's or, with local tiles, a group's
  int64_t all_scratch_floats = 0;
  int64_t tile_queries = 0;
  // Queries that all work-groups process at once, or a multiple: no work-group waits at a chunk's
  // end.
  int64_t chunk_queries = 0;
};

class PosteriorShapes {
 public:
  // Uses the device's tuning, or what FitLocalMemory makes of it for points of
  // `point_width` values. Throws cl::Error.
  PosteriorShapes(const Context& context, int64_t point_width);

  const FactorBlocking& blocking() const { return blocking_; }
  const char* file() const {
    return tuning_.local_tiles ? "dense_posterior_local.cl" : "dense_posterior.cl";
  }
  std::string BuildOptions(const Context& context, FactorKind kind) const;
  // count: the model's points. cap_bytes: half for scratch, the other half for queries.
  PosteriorTiling Tile(const Context& context, FactorKind kind, int64_t count, int64_t query_count,
                       int64_t cap_bytes) const;

 private:
  int Width(FactorKind kind) const {
    return kind == FactorKind::kNone ? tuning_.mean_width : tuning_.width;
  }
  // Number of work-items side by side along rows, with local tiles.
  int Panels(FactorKind kind) const {
    return kind == FactorKind::kNone ? 1 : tuning_.panels_per_group;
  }
  int MicroTileQueries(FactorKind kind) const {
    return Width(kind) *
           (tuning_.local_tiles ? tuning_.work_group / Panels(kind) : tuning_.float_lanes);
  }

  KernelTuning tuning_;
  int staged_points_;
  FactorBlocking blocking_;
  int64_t point_width_;
};

}  // namespace egosieve::kernels::opencl
