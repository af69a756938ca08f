// Patches of grey pictures. Patches are compared after subtracting the mean.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <numeric>
#include <opencv2/core.hpp>

#include "vision/image/bilinear.h"

namespace egosieve::vision {

inline constexpr int kPatchRadius = 3;
inline constexpr int kPatchSide = 2 * kPatchRadius + 1;
inline constexpr int kPatchPixels = kPatchSide * kPatchSide;

// A patch has texture from this root mean square on, in noise levels, and in both directions from
// this smaller eigenvalue of its structure tensor on, as a share of the trace.
inline constexpr double kLeastTexture = 2.0, kLeastCorner = 0.1;
// Two patches show one surface up to this squared difference, as a share of the square of one.
inline constexpr double kMostChange = 0.15;
// Changes of scale below this are left out: a sixth of a pixel at a patch's edge.
inline constexpr double kLeastScaling = 0.05;

// Row by row, like all patches.
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

// Positions of a patch's pixels in a picture under a projective motion: homogeneous pixel
// coordinates, linear in the coordinates within the patch.
struct ProjectedPlaces {
  Eigen::Vector3d centre, across, down;
};

// The patch of 2 kHalfWidth + 1 by 2 kHalfHeight + 1 pixels, each sampled at its position in
// `places` by SampleOrNan.
template <int kHalfWidth, int kHalfHeight>
auto TakeProjected(const cv::Mat& picture, const ProjectedPlaces& places) {
  constexpr int kWidth = 2 * kHalfWidth + 1, kPixels = kWidth * (2 * kHalfHeight + 1);
  std::array<double, kPixels> x, y;  // in a loop of their own, which the compiler vectorises
  for (int i = 0; i < kPixels; ++i) {
    const double u = i % kWidth - kHalfWidth, v = i / kWidth - kHalfHeight;
    const double z = places.centre(2) + u * places.across(2) + v * places.down(2);
    x[i] = (places.centre(0) + u * places.across(0) + v * places.down(0)) / z;
    y[i] = (places.centre(1) + u * places.across(1) + v * places.down(1)) / z;
  }
  std::array<float, kPixels> patch;
  for (int i = 0; i < kPixels; ++i) patch[i] = SampleOrNan(picture, x[i], y[i]);
  return patch;
}

}  // namespace egosieve::vision
