// Our own random numbers, so that a seed draws the same samples with every standard library.
#ifndef EGOSIEVE_VISION_PAPER_SAMPLING_H_
#define EGOSIEVE_VISION_PAPER_SAMPLING_H_

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace egosieve::vision {

class Sampler {
 public:
  explicit Sampler(uint64_t seed) : engine_(seed) {}

  // Uniform in [0, bound); bound > 0. The bias of the multiply-and-shift is below bound / 2^32.
  int64_t Below(int64_t bound) {
    return static_cast<int64_t>((engine_() >> 32) * static_cast<uint64_t>(bound) >> 32);
  }

  // `count` different indices below `bound`, count <= bound.
  template <size_t count>
  void Distinct(int64_t bound, int64_t (&indices)[count]) {
    for (size_t i = 0; i < count; ++i) {
      do {
        indices[i] = Below(bound);
      } while (std::find(indices, indices + i, indices[i]) != indices + i);
    }
  }

  template <typename T>
  void Shuffle(std::vector<T>& values) {
    for (int64_t i = static_cast<int64_t>(values.size()) - 1; i > 0; --i) {
      std::swap(values[i], values[Below(i + 1)]);
    }
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_PAPER_SAMPLING_H_
