// The colours of moving and of static pixels, learnt from pictures and their maps.
//
//   bin(x)    Lab colour in 16 steps per axis                                                  (C1)
//   F, G      sums of p^3 and of (1 - p)^3 over the pixels of a bin: pixels with p near 0 or 1
//             count, others hardly. Smoothed along each axis by [1/4, 1/2, 1/4]                (C2)
//   f, g      F and G divided by their sums, plus a floor
//   evidence  k log(f / g), clamped to [-limit, limit], k = s / (s + support), s the smaller of
//             the two sums: the evidence is 0 without pixels of both kinds                     (C3)
//
// Histograms of single pictures are added to give that of a window. Cost: linear in the pixels and
// in the 4,096 bins.
//
// Reference: Boykov & Jolly (2001) for colour as a term of a segmentation; here with soft seeds.
#ifndef EGOSIEVE_VISION_MASKS_COLOUR_MODEL_H_
#define EGOSIEVE_VISION_MASKS_COLOUR_MODEL_H_

#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/status.h"

namespace egosieve::vision {

struct ColourModelOptions {
  double support_pixels = 200.0;  // positive
  double limit = 3.0;             // of the evidence, log odds; positive

  absl::Status Validate() const;
};

// (C1) of a picture in B G R: the bin of each pixel, below 4,096.
cv::Mat1w ColourBins(const cv::Mat3b& image);

class ColourModel {
 public:
  ColourModel();

  // bins: ColourBins of a picture. probability: of moving, of the same size.
  void Add(const cv::Mat1w& bins, const cv::Mat1f& probability);
  void Add(const ColourModel& other);

  // (C3) of a picture of these bins; `options` must be valid.
  cv::Mat1f Evidence(const cv::Mat1w& bins, const ColourModelOptions& options) const;

 private:
  std::vector<float> moving_, still_;  // F, G before smoothing
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_MASKS_COLOUR_MODEL_H_
