// Division of a dense posterior's queries into tiles, work-groups and chunks, with the
// corresponding build options.
#pragma once

#include <cstdint>
#include <string>

#include "kernels/base/posterior_model.h"
#include "kernels/ops/packed_factor.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

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
  // Uses the device's tuning, or what kernels/ops/local_tiles.h makes of it for points of
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
