// Optical-flow classification of moving objects, per frame and without memory, after Klappstein,
// Vaudrey, Rabe, Wedel and Klette (2009), "Moving object segmentation using optical flow and depth
// information", for one camera. It measures the distance of a point pair from all possible
// positions of a static point.
//
// Let R be the rotation and t the translation between the frames. A static point at x1 appears in
// the second frame on a segment of its epipolar line, at a place given by its inverse depth s (in
// units of 1 / |t|):
//
//   x2(s) ~ K R K^-1 x1 + s K t,     0 <= s <= s_road(x1)                                     (OF1)
//
//   epipolar constraint    x2 lies on the line; else the distance to it
//   positive depth         s >= 0; else the distance to x2(0), the place of a point at infinity
//   positive height        s <= s_road: nothing lies below the road; else the distance to
//                          x2(s_road)
//
// The violation is the distance to the segment, in pixels. R and t come from the fundamental matrix
// and the focal length, which is guessed if it is not given. Of the four decompositions the one
// with the smallest violations is taken. The line itself comes from F, so that a wrong guess does
// not affect it.
//
// Road: a plane below the camera, n = (0, 1, 0), at height h (in units of |t|): s_road = (K^-1
// x1)_y / h. h is the densest of the values (K^-1 x1)_y / s of points in the lower half of the
// image, if at least `minimum_road_share` of these are within 10 % of it.
//
// Without translation (homography, static) the violation is the residual.
#ifndef EGOSIEVE_VISION_BASELINES_OPTICAL_FLOW_CLASSIFIER_H_
#define EGOSIEVE_VISION_BASELINES_OPTICAL_FLOW_CLASSIFIER_H_

#include <Eigen/Core>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/geometry/motion_model_kind.h"
#include "vision/geometry/point_pair.h"

namespace egosieve::vision {

struct OpticalFlowClassifierOptions {
  double focal_length_pixels = 0.0;  // 0: 0.7 times the longer side of the image
  double minimum_road_share = 0.2;   // (0, 1]
  double tolerance_pixels = 1.0;  // along the line, before depth or height counts as violated; >= 0

  absl::Status Validate() const;
};

struct OpticalFlowClassification {
  std::vector<double> violation_pixels;  // one per pair
  double road_height = 0.0;              // h, in units of |t|; 0: no road found
};

// `matrix` is F or H in pixels, first image to second. InvalidArgument for invalid options or an
// empty image.
absl::StatusOr<OpticalFlowClassification> ClassifyOpticalFlow(
    const std::vector<PointPair>& pairs, MotionModelKind kind, const Eigen::Matrix3d& matrix,
    int image_width, int image_height, const OpticalFlowClassifierOptions& options);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_BASELINES_OPTICAL_FLOW_CLASSIFIER_H_
