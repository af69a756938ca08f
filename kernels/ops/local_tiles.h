// Shapes of the dense posterior for points that are wide in comparison with the device's local
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

#include "kernels/runtime/tuning.h"

namespace egosieve::kernels::opencl {

// `tuning` if it has no local tiles or (1) fits in local_bytes; else with panels_per_group halved
// until it fits, and a depth that divides G. If no valid shape fits, DefaultTuning(1) with 64
// work-items side by side, which needs no local memory. In (1) G P is taken as G (P + 1), since a
// driver may need some of the memory.
KernelTuning FitLocalMemory(const KernelTuning& tuning, int64_t point_width, int64_t local_bytes);

// S of (2): 64, SUM_BLOCK of kernels/cl/posterior_outputs.cl, halved until (2) fits.
int StagedPoints(int64_t point_width, int64_t local_bytes);

}  // namespace egosieve::kernels::opencl
