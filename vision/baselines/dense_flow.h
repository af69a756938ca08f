// Dense flow on the second picture's grid, and its residual against a homography.
//
//   pair of grid pixel x2: x1 = x2 + b(x2), b the flow from the second picture to the first (DF1)
//   distance |x2 - H x1|, H the homography that most textured, consistent grid points fit   (DF2)
//
// Every grid pixel has a pair: no flow is discarded, however unreliable.
#ifndef EGOSIEVE_VISION_BASELINES_DENSE_FLOW_H_
#define EGOSIEVE_VISION_BASELINES_DENSE_FLOW_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/image_grid.h"
#include "vision/geometry/motion_model.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct DenseFlow {
  std::vector<PointPair> pairs;     // (DF1), one per grid pixel, row-major
  std::vector<PointPair> reliable;  // of a 5-pixel grid: textured, and consistent in both
                                    // directions
};

// Grey CV_8UC1 pictures of the grid's size, at least 16 pixels in each direction; errors of the
// flow.
absl::StatusOr<DenseFlow> FlowAtGrid(const cv::Mat& first, const cv::Mat& second,
                                     const kernels::ImageGrid& grid);

// (DF2), one per grid pixel; empty, without an error, if no homography was found.
absl::StatusOr<std::vector<double>> HomographyDistances(const DenseFlow& flow, uint64_t seed);

// A fundamental matrix from the reliable pairs; kind kNone if there is none.
absl::StatusOr<MotionModel> FundamentalMatrixOf(const DenseFlow& flow, uint64_t seed);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_BASELINES_DENSE_FLOW_H_
