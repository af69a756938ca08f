// Patches of 7 x 7 pixels, compared less their means.
#ifndef EGOSIEVE_VISION_EVIDENCE_PATCH_H_
#define EGOSIEVE_VISION_EVIDENCE_PATCH_H_

#include <array>
#include <numeric>

namespace egosieve::vision {

inline constexpr int kPatchRadius = 3;
inline constexpr int kPatchSide = 2 * kPatchRadius + 1;
inline constexpr int kPatchPixels = kPatchSide * kPatchSide;

using Patch = std::array<float, kPatchPixels>;  // row by row

// Returns the mean.
inline float SubtractMean(Patch& patch) {
  const float mean = std::accumulate(patch.begin(), patch.end(), 0.0f) / kPatchPixels;
  for (float& value : patch) value -= mean;
  return mean;
}

inline double SquaredDifference(const Patch& a, const Patch& b) {
  float sum = 0.0f;
  for (int i = 0; i < kPatchPixels; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_PATCH_H_
