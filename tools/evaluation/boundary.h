// How well outlines agree: boundary measure F of DAVIS.
//
//   boundary   pixels whose mask differs from the pixel to the right, below, or right below
//   precision  share of the prediction's boundary within r pixels of the truth's
//   recall     share of the truth's boundary within r pixels of the prediction's
//   F = 2 precision recall / (precision + recall),   r = ceil(0.008 diagonal)
//
// Both boundaries empty: F = 1; one empty: 0. Void pixels first get the static value in both masks.
// Distances are Euclidean, between pixel centres.
//
// Reference: Perazzi et al., A Benchmark Dataset and Evaluation Methodology for Video Object
// Segmentation (CVPR 2016), section 4; as there, bipartite matching is approximated by dilation.
#ifndef EGOSIEVE_TOOLS_EVALUATION_BOUNDARY_H_
#define EGOSIEVE_TOOLS_EVALUATION_BOUNDARY_H_

#include <opencv2/core.hpp>

#include "absl/status/statusor.h"

namespace egosieve::tools {

struct BoundaryScore {
  double precision = 0.0;
  double recall = 0.0;
  double f = 0.0;
};

// mask: not 0 inside. `void_pixels`: not 0 where the truth is unknown; may be empty.
// InvalidArgument, naming both sizes, if the sizes differ.
absl::StatusOr<BoundaryScore> BoundaryF(const cv::Mat1b& prediction, const cv::Mat1b& truth,
                                        const cv::Mat1b& void_pixels = {},
                                        double bound_share = 0.008);

// 255 on the boundary, else 0.
cv::Mat1b BoundaryOf(const cv::Mat1b& mask);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_BOUNDARY_H_
