// The motion of one mover between two pictures: affine, and close to a translation.
//
//   d(x)   = v + G (x - c), c the mean of the places x_i                                    (D1)
//   v, G   minimise sum_i w_i (|d_i - d(x_i)|^2 + stiffness^2 |G|^2)                         (D2)
//   w_i    = 1 / (1 + (|d_i - d(x_i)| / scale)^2)^2, iterated from the median of d_i: Geman and
//            McClure's weights
//
// The stiffness is a length: where a mover's points spread less than it, they hardly determine G.
// Without it, a region that covers two movers would be fitted by a shear.
//
// Units: pixels. Cost: linear in the points.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

struct MoverMotion {
  cv::Point2d centre;    // c
  cv::Point2d shift;     // v
  cv::Matx22d gradient;  // G

  cv::Point2d At(cv::Point2d place) const;      // (D1)
  cv::Point2d Source(cv::Point2d place) const;  // solves y + d(y) = place for y
};

// (D2). Zero motion without places.
MoverMotion FitMotion(const std::vector<cv::Point2f>& places,
                      const std::vector<cv::Point2f>& displacements, double scale);

}  // namespace egosieve::vision
