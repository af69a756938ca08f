// What the machine can do at best, measured in the run that it is compared with.
#ifndef EGOSIEVE_BENCH_KERNELS_ROOFLINE_H_
#define EGOSIEVE_BENCH_KERNELS_ROOFLINE_H_

#include <chrono>
#include <cstdint>

#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// Vector arithmetic operations (a multiply-add counts one) times lanes, a second, of the device: a
// kernel of independent multiply-adds of T, float or double, in registers. The best of all runs in
// this process: a peak that a noisy moment lowered would flatter what is compared with it. 0 where
// there is no such device.
template <typename T>
double FmaPerSecond(Context& context);

// Seconds of OpenBLAS's strsm, or Eigen's triangular solve on all cores, the better of the two:
// L^-1 B in float32 with L n x n and B n x m.
double StrsmSeconds(int64_t n, int64_t m);

// Bytes a second of a copy in memory on all cores, read and written bytes counted.
double CopyBytesPerSecond();

// The wall's seconds an iteration of a benchmark's loop, for counters that are no rates.
class LoopTimer {
 public:
  double SecondsAnIteration(int64_t iterations) const {
    const auto elapsed = std::chrono::steady_clock::now() - begin_;
    return std::chrono::duration<double>(elapsed).count() / static_cast<double>(iterations);
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_BENCH_KERNELS_ROOFLINE_H_
