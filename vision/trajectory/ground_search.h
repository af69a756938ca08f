// The likelihood of the ground's speed (ground_speed.h) from a few pictures within a fraction of a
// second.
//
// On blank asphalt flow finds nothing, and it loses lane marks, which are narrow and fast. But a
// single number, the speed v, describes the motion of the whole road. Let the rotations be known
// and the camera be upright, with the horizon at h. A road point with ray p below the horizon has
// the inverse depth r = v (p_y - h) (GB1), so in the picture dt_k later it is at
//
//   q_k(p, v) = proj R_k (p + r dt_k tau)                                                    (SR1)
//
// tau is the direction of the translation in X_2 = R X_1 + t between two pictures, the second of
// which is later. The fixed pattern of the image, such as bonnet and reflections, is subtracted
// first: a_k = I_k - mean over k of I_k. At the right v the a_k of a point agree with their mean
// over k. Points with contrast within kAcross camera heights of the line of travel are gathered in
// cells. For a cell with n values from m points
//
//   l_C(v) = -n / 2 log( s_mean^2 / s^2 ),   s^2 = sum a_k^2 / n + noise                     (SR2)
//            s_mean^2 = sum (a_k - mean over k of a_k)^2 / (n - m) + noise
//
// which is the log-likelihood for Gaussian noise of unknown deviation, as in the semblance of
// seismology. A cell C is either road, which moves with the ground, or another object such as
// traffic. An object has its own speed v', lower than the ground's if it travels in the camera's
// direction:
//
//   L(v) = sum over C of log( exp(l_C(v)) / 2 + sum over v' of p(v' | v) exp(l_C(v')) / 2 ) (SR3)
//
// l_C is divided by kPixelCorrelation and is limited to at most kMostOfCell below its maximum over
// the speeds. L is divided by the number of pictures, since each picture enters that many
// likelihoods of the drive. Reference: Neidell & Taner (1971), semblance.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/geometry/pinhole.h"
#include "vision/trajectory/ground_speed.h"

namespace egosieve::vision {

struct GroundPicture {
  cv::Mat grey;                                            // CV_8UC1
  double seconds = 0.0;                                    // after the first; 0 for the first
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // R_k, from the first picture
};

// The rotation about the same axis by `share` of the angle.
Eigen::Matrix3d PartOfRotation(const Eigen::Matrix3d& rotation, double share);

struct GroundSearchView {
  std::vector<GroundPicture> pictures;                    // of one size
  Eigen::Vector3d direction = -Eigen::Vector3d::UnitZ();  // tau, a unit vector
  Pinhole camera;
  cv::Mat1b ignored;  // the own vehicle, see ignored_area.h
};

// All values are equal where the camera does not move forward or back, where the pictures do not
// differ, and for fewer than three pictures.
SpeedLikelihood LikelihoodOfSpeeds(const GroundSearchView& view);

}  // namespace egosieve::vision
