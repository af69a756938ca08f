// Where in the image things have moved so far.
//
// On a road most of what moves passes through the same part of the image: what comes there next is
// more probably a mover than what comes elsewhere, the more so while it is too small and too far to
// be labelled. With d(x) the density of dynamic labels around a place, summed over the drive with
// forgetting, d_mean its mean over the image and n the frames that it rests on, the odds of the
// process's probability are multiplied by
//
//   ( (n d(x) / d_mean + n0) / (n + n0) )^w                                                  (L1)
//
// Bayes' rule for places, p(x | dynamic) / p(x), less bold: w < 1 because the process has the place
// among its inputs already, and the same object labels the same place in frame after frame. Without
// dynamic labels so far nothing changes.
//
// The state is some thousand numbers, whatever the image's size; places are relative to the image.
#ifndef EGOSIEVE_VISION_SEGMENTATION_LOCATION_PRIOR_H_
#define EGOSIEVE_VISION_SEGMENTATION_LOCATION_PRIOR_H_

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
  double weight = 0.0;   // w; in [0, 1], 0: nothing is learnt or changed
  double memory = 0.99;  // of d and n, from frame to frame; in [0, 1]

  absl::Status Validate() const;
};

class LocationPrior {
 public:
  explicit LocationPrior(const LocationPriorOptions& options);

  // A frame's labels, if it has any. A standing camera teaches nothing: one red light would
  // outweigh the street.
  void Learn(const LabelledFrame& labels);

  // positions: N x 2, pixels, within an image of `size`; labels: N, in [0, 1].
  void Add(cv::Size size, kernels::ConstMatrixView<double> positions,
           absl::Span<const double> labels);

  // (L1), on the map's probability.
  void Apply(SegmentationMap& map) const;

  // The state; equal states give equal bytes.
  std::string ToBytes() const;
  // InvalidArgument for bytes that ToBytes did not write; unchanged then.
  absl::Status Restore(std::string_view bytes);

 private:
  LocationPriorOptions options_;
  std::vector<float> labels_;  // kRows x kColumns: sums of dynamic labels
  double frames_ = 0.0;        // n
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_LOCATION_PRIOR_H_
