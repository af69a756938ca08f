// SIFT descriptors (Lowe, 2004, section 6) at given positions, scales and orientations.
//
// Levels: the image blurred to standard deviations, in pixels of the image,
//
//   sigma(o, j) = 0.8 2^(o + j/3),   j = 0, 1, 2,                                             (SD1)
//
// Octave o is sampled at every 2^o-th pixel, so that each level is sampled finely without waste:
// Lowe's levels without his doubled image. A point of scale sigma is described on the nearest
// level. Its gradients are weighted by a Gaussian with a deviation of 2 bins. They go into 4 x 4 x
// 8 histograms with bins of 3 sigma, each gradient shared among its eight nearest bins. Then
//
//   h := h / |h|,   h := min(h, 0.2),   h := h / |h|,   byte = round(512 h), at most 255
//
// Cost: linear in the pixels and in the points. The result does not depend on `threads`.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

struct DescribedPlace {
  cv::Point2f position;              // pixels
  float sigma = 1.6F;                // scale, pixels
  float orientation_degrees = 0.0F;  // of the gradient, y downwards: as cv::KeyPoint's
};

class SiftDescriber {
 public:
  // grey: CV_8UC1, not empty.
  explicit SiftDescriber(const cv::Mat& grey);

  // out: places.size() x 128 bytes. A point without any gradient around it gets zeros.
  void Describe(const std::vector<DescribedPlace>& places, int threads, uint8_t* out) const;

 private:
  static constexpr int kLevelsPerOctave = 3;
  struct Level {
    cv::Mat magnitude, angle_bins;  // CV_32F; angles in [0, 8)
    float pixels_per_sample = 1.0F;
  };
  const Level& LevelFor(float sigma) const;
  static void DescribeOne(const Level& level, const DescribedPlace& place, uint8_t* out);

  std::vector<Level> levels_;  // (SD1), by o and then j
};

}  // namespace egosieve::vision
