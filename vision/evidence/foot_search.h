// The row of a column of the image where the road ends and what stands on it begins, by the
// pictures.
//
// Flow is smooth and its places lie some pixels apart: by them alone, a foot is found up to two
// places from where it is. The pictures know the row. With E_road(y) and E_object(y) what a strip
// of 7 x 3 pixels around row y differs by from its place in the frame before (S1), moved as the
// road is there, or as something is that has the inverse depth r,
//
//   g(y) = kappa (E_road(y) - E_object(y)) / (2 v),   S(b) = sum of g over the rows above b   (B1)
//
// is the log-likelihood ratio of a foot at row b, g bounded row by row. All rows may have the foot
// whose S is less than kDoubt below the greatest: the lowest of them is the nearest foot there may
// be, and what is too near for it is too near for all of them.
#ifndef EGOSIEVE_VISION_EVIDENCE_FOOT_SEARCH_H_
#define EGOSIEVE_VISION_EVIDENCE_FOOT_SEARCH_H_

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "vision/evidence/pinhole.h"
#include "vision/evidence/relative_pose.h"
#include "vision/evidence/road_plane.h"

namespace egosieve::vision {

class FootSearch {
 public:
  // pose: before to now, found; pictures: CV_8UC1 of one size; noise_levels: of PhotometricSupport.
  FootSearch(const RoadPlane& road, const Pinhole& camera, const RelativePose& pose, cv::Mat before,
             cv::Mat now, double noise_levels);

  // The ray of the lowest foot that there may be of something of inverse depth r that is seen at
  // `top` and not at `bottom`, which is below it in the same column, pixels; that of `bottom` where
  // the pictures do not tell.
  Eigen::Vector3d LowestFoot(cv::Point2f top, cv::Point2f bottom, double inverse_depth) const;

 private:
  double Gain(double x, double y, double inverse_depth) const;  // g of (B1); NaN beyond the picture

  RoadPlane road_;
  Pinhole camera_;
  RelativePose back_;  // now to before
  cv::Mat before_, now_;
  double noise_levels_;
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_EVIDENCE_FOOT_SEARCH_H_
