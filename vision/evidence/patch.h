// Grey pictures between pixels, and patches of 7 x 7 pixels of them, compared less their means.
#ifndef EGOSIEVE_VISION_EVIDENCE_PATCH_H_
#define EGOSIEVE_VISION_EVIDENCE_PATCH_H_

#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <opencv2/core.hpp>

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

// Bilinear, of a CV_8UC1 picture; NaN outside of it.
inline float SampleAt(const cv::Mat& picture, double x, double y) {
  if (!(x >= 0 && y >= 0 && x < picture.cols - 1 && y < picture.rows - 1)) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const float fx = static_cast<float>(x - column), fy = static_cast<float>(y - row);
  const uint8_t* upper = picture.ptr<uint8_t>(row) + column;
  const uint8_t* lower = picture.ptr<uint8_t>(row + 1) + column;
  const float above = upper[0] + fx * (upper[1] - upper[0]);
  const float below = lower[0] + fx * (lower[1] - lower[0]);
  return above + fy * (below - above);
}

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_PATCH_H_
