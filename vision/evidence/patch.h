// Grey pictures between pixels, and patches of them, compared less their means.
#ifndef EGOSIEVE_VISION_EVIDENCE_PATCH_H_
#define EGOSIEVE_VISION_EVIDENCE_PATCH_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <opencv2/core.hpp>

namespace egosieve::vision {

inline constexpr int kPatchRadius = 3;
inline constexpr int kPatchSide = 2 * kPatchRadius + 1;
inline constexpr int kPatchPixels = kPatchSide * kPatchSide;

// Row by row, as all patches.
using Patch = std::array<float, kPatchPixels>;

// Returns the mean.
template <size_t kPixels>
float SubtractMean(std::array<float, kPixels>& patch) {
  const float mean = std::accumulate(patch.begin(), patch.end(), 0.0f) / kPixels;
  for (float& value : patch) value -= mean;
  return mean;
}

template <size_t kPixels>
double SquaredDifference(const std::array<float, kPixels>& a, const std::array<float, kPixels>& b) {
  float sum = 0.0f;
  for (size_t i = 0; i < kPixels; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
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

// The patch of 2 kHalfWidth + 1 by 2 kHalfHeight + 1 pixels around (x, y), each taken from where
// `motion` has it. NaN where it leaves the picture.
template <int kHalfWidth, int kHalfHeight, typename Motion>
std::array<float, (2 * kHalfWidth + 1) * (2 * kHalfHeight + 1)> TakeMoved(const cv::Mat& picture,
                                                                          double x, double y,
                                                                          const Motion& motion) {
  std::array<float, (2 * kHalfWidth + 1) * (2 * kHalfHeight + 1)> patch;
  for (int v = -kHalfHeight, i = 0; v <= kHalfHeight; ++v) {
    for (int u = -kHalfWidth; u <= kHalfWidth; ++u, ++i) {
      const Eigen::Vector2d at = motion(Eigen::Vector2d(x + u, y + v));
      patch[i] = SampleAt(picture, at(0), at(1));
    }
  }
  return patch;
}

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_PATCH_H_
