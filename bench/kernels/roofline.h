// Peak speeds of the machine, measured in the same run as the figures that are compared with them.
#pragma once

#include <chrono>
#include <cstdint>

#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// Vector arithmetic operations (a multiply-add counts one) times lanes, per second, of the device:
// a kernel of independent multiply-adds of T, float or double, in registers. The best of all runs
// in this process is taken: a peak lowered by a moment of noise would make the compared figures
// look better. 0 if there is no such device.
template <typename T>
double FmaPerSecond(Context& context);

// Seconds for L^-1 B in float32, with L n x n and B n x m: OpenBLAS's strsm or Eigen's triangular
// solve on all cores, the faster of the two.
double StrsmSeconds(int64_t n, int64_t m);

// Bytes per second of a copy in memory on all cores, counting bytes read and written.
double CopyBytesPerSecond();

// Wall-clock seconds per iteration of a benchmark's loop, for counters that are not rates.
class LoopTimer {
 public:
  double SecondsPerIteration(int64_t iterations) const {
    const auto elapsed = std::chrono::steady_clock::now() - begin_;
    return std::chrono::duration<double>(elapsed).count() / static_cast<double>(iterations);
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace egosieve::kernels
