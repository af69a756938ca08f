// How often things have moved at each place of the image so far.
//
// On a road most traffic passes through the same part of the image. There a new object is more
// probably a mover than elsewhere, above all while it is too small and too far to be labelled. Let
// d(x) be the density of dynamic labels around a place, summed over the drive with forgetting,
// d_mean its mean over the image, and n the number of frames in the sum, with the same forgetting.
// The odds of the Gaussian process's probability are multiplied by
//
//   ( (n d(x) / d_mean + n0) / (n + n0) )^w                                                 (LP1)
//
// This is Bayes' rule for places, p(x | dynamic) / p(x), with less weight: w < 1 because the
// Gaussian process already has the place among its inputs, and because the same object labels the
// same place in frame after frame. Without dynamic labels so far nothing changes.
//
// The state is some thousand numbers, for any image size; places are relative to the image.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/segmentation/segmentation_map.h"

namespace egosieve::vision {

struct LocationPriorOptions {
  double weight = 0.0;   // w; in [0, 1]; 0: off
  double memory = 0.99;  // factor of d and n per frame; in [0, 1]
};

class LocationPrior {
 public:
  explicit LocationPrior(const LocationPriorOptions& options);

  // Adds a frame's labels, if it has any. Frames of a standing camera are left out: one red light
  // would outweigh the street.
  void Learn(const LabelledFrame& labels);

  // positions: N x 2, pixels, within an image of `size`; labels: N, in [0, 1].
  void Add(cv::Size size, kernels::ConstMatrixView<double> positions,
           absl::Span<const double> labels);

  // Applies (LP1) to the map's probability.
  void Apply(SegmentationMap& map) const;

  // The state; equal states give equal bytes.
  std::string ToBytes() const;
  // InvalidArgument for bytes that ToBytes did not write; then nothing changes.
  absl::Status Restore(std::string_view bytes);

 private:
  LocationPriorOptions options_;
  std::vector<float> labels_;  // by cell: sums of dynamic labels
  double frames_ = 0.0;        // n
};

}  // namespace egosieve::vision
