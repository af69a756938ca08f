// The likelihood of the ground's speed (ground_speed.h), from two consecutive pictures themselves.
//
// On blank asphalt flow finds nothing, and lane marks, narrow and fast, are lost; but one number
// describes how all of the road moves. With the rotation known, a place of the road with ray p,
// below the horizon of a camera that is upright, has the inverse depth r = g (p_y - h) (GB1), so it
// was at
//
//   q(p, g) = (p + r tau) / (1 + r tau_z),   g = v dt                                      (SR1)
//
// in the picture before; tau is the direction from the current camera to the one before. Places
// that changed, with contrast, within kAcross camera heights of the line of travel, are gathered in
// cells. A pixel's ratio against chance, h the histogram of grey levels there:
//
//   l(g) = log( 0.8 N(I(p) - I'(q); 0, s^2) / h(I(p)) + 0.2 )                              (SR2)
//
// A cell C is the road, and moves as the ground does, or it is something else, such as traffic,
// that moves on with its own g', slower than the ground where it goes the same way:
//
//   L(v) = sum over C of log( exp(l_C(v dt)) / 2 + sum over g' of p(g' | v) exp(l_C(g')) / 2 )
//                                                                                          (SR3)
//
// l_C sums the pixels of the cell, over kPixelCorrelation, within kMostOfCell of its best. Without
// ground all is something else, with any g'.
#ifndef EGOSIEVE_VISION_TRAJECTORY_GROUND_SEARCH_H_
#define EGOSIEVE_VISION_TRAJECTORY_GROUND_SEARCH_H_

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "vision/evidence/pinhole.h"
#include "vision/trajectory/ground_speed.h"

namespace egosieve::vision {

struct GroundSearchView {
  cv::Mat before, now;                                     // CV_8UC1, of one size
  double seconds = 0.0;                                    // between them, positive
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // from `now` to `before`
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();    // tau: t of `now` to `before`, unit
  Pinhole camera;
  cv::Mat1b ignored;  // ignored_area.h: the own vehicle
};

// All equal where the camera does not move forward or back, and where nothing changed.
SpeedLikelihood LikelihoodOfSpeeds(const GroundSearchView& view);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_GROUND_SEARCH_H_
