// Places of a picture whose texture is a line along the direction of travel: lane lines, kerbs, the
// edges of a road.
//
// Moved along itself such a line looks the same: flow measures only the part of its motion across
// the line (the aperture problem). The part along it, which gives the place's depth, comes from
// where the search began and from the surroundings. With e the direction in which a static place
// moves in the picture ((TV3) of two_view_motion.h, tau the direction of travel) and S the
// structure tensor of grey levels, a place is on such a line if it is below the horizon and
//
//   e'Se < kMostShare |e|^2 trace S,   trace S >= kLeastTexture                              (LT1)
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "vision/geometry/pinhole.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

class LinesAlongTravel {
 public:
  // grey: CV_8UC1. travel: tau, of a camera that moves forward or back.
  LinesAlongTravel(const cv::Mat& grey, const Pinhole& camera, const Eigen::Vector3d& travel);

  // place: in the picture, pixels.
  bool Contain(cv::Point2f place) const;

 private:
  cv::Mat1f s_xx_, s_xy_, s_yy_;
  Pinhole camera_;
  Eigen::Vector3d travel_;
};

// Whether a place that `motion` sees at `now` and at `there` seems to lie on the ground or beyond
// it. False where the ground is not known.
bool SeemsNoNearerThanGround(const TwoViewMotion& motion, const Pinhole& camera, cv::Point2f now,
                             cv::Point2f there);

}  // namespace egosieve::vision
