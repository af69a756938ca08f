// The finaliser of splitmix64 (Steele, Lea & Flood 2014): numbers that differ in one bit become
// unrelated 64-bit numbers. Seeds made with it need no generator state.
#pragma once

#include <cstdint>

namespace egosieve::kernels {

// The increment of the generator's state between two numbers.
inline constexpr uint64_t kSplitMixStep = 0x9E3779B97F4A7C15u;

inline uint64_t SplitMix(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

}  // namespace egosieve::kernels
