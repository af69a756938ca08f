// Standard normal values that follow from a key: splitmix64, counted from the key, by the
// Box-Muller transform.
//
// References: Box & Muller (1958); Steele, Lea & Flood (2014).
#pragma once

#include <cmath>
#include <cstdint>

#include "kernels/base/splitmix.h"

namespace egosieve::gp {

// Pair number `pair` of two independent normal values.
inline void NormalPair(uint64_t key, uint64_t pair, double& first, double& second) {
  const auto uniform = [key](uint64_t place) {  // in (0, 1)
    const uint64_t bits = kernels::SplitMix(key + kernels::kSplitMixStep * place);
    return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
  };
  const double radius = std::sqrt(-2.0 * std::log(uniform(2 * pair)));
  const double angle = 2.0 * M_PI * uniform(2 * pair + 1);
  first = radius * std::cos(angle);
  second = radius * std::sin(angle);
}

// The values one after another.
class NormalStream {
 public:
  explicit NormalStream(uint64_t key) : key_(key) {}

  double operator()() {
    if (count_++ % 2 == 1) return second_;
    double first;
    NormalPair(key_, count_ / 2, first, second_);
    return first;
  }

 private:
  uint64_t key_;
  uint64_t count_ = 0;
  double second_ = 0.0;
};

}  // namespace egosieve::gp
