// What the machine can do at best, measured in the run that it is compared with.
#ifndef EGOSIEVE_BENCH_KERNELS_ROOFLINE_H_
#define EGOSIEVE_BENCH_KERNELS_ROOFLINE_H_

#include <cstdint>

#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// Vector arithmetic operations (a multiply-add counts one) times lanes, a second, of the device: a
// kernel of independent float32 multiply-adds in registers. The best of several runs.
double FmaPerSecond(Context& context);

// Seconds of OpenBLAS's strsm, or Eigen's triangular solve on all cores, the better of the two:
// L^-1 B in float32 with L n x n and B n x m.
double StrsmSeconds(int64_t n, int64_t m);

// Bytes a second of a copy in memory on all cores, read and written bytes counted.
double CopyBytesPerSecond();

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_BENCH_KERNELS_ROOFLINE_H_
