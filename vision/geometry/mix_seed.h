// Seeds of random choices.
#pragma once

#include <cstdint>

#include "kernels/base/splitmix.h"

namespace egosieve::vision {

// A seed for one step of one frame, from the run's seed.
inline uint64_t MixSeed(uint64_t seed, uint64_t frame_index, uint64_t step) {
  uint64_t z = seed;
  for (const uint64_t value : {frame_index, step}) {
    z = kernels::SplitMix(z + kernels::kSplitMixStep + value);
  }
  return z;
}

}  // namespace egosieve::vision
