// The likelihood of the ground's speed (ground_speed.h), from a few pictures of a fraction of a
// second.
//
// On blank asphalt flow finds nothing, and lane marks, narrow and fast, are lost; but one number
// describes how all of the road moves. With the rotations known, a place of the road with ray p,
// below the horizon of a camera that is upright, has the inverse depth r = v (p_y - h) (GB1), so in
// the picture dt_k later it is at
//
//   q_k(p, v) = proj R_k (p + r dt_k tau)                                                    (SR1)
//
// tau is the direction of X_2 = R X_1 + t between pictures of which the second is later. What is
// fixed in the image, bonnet and reflections, is taken away first: a_k = I_k - mean over k of I_k.
// Where v is right, the places of a_k agree with their mean over k. Of places with contrast within
// kAcross camera heights of the line of travel, gathered in cells, with n values from m places,
//
//   l_C(v) = -n / 2 log( s_mean^2 / s^2 ),   s^2 = sum a_k^2 / n + noise                     (SR2)
//            s_mean^2 = sum (a_k - mean over k of a_k)^2 / (n - m) + noise
//
// that is Gaussian noise of unknown size, as in the semblance of seismology. A cell C is the road,
// and moves as the ground does, or it is something else, such as traffic, that moves on with its
// own v', slower than the ground where it goes the same way:
//
//   L(v) = sum over C of log( exp(l_C(v)) / 2 + sum over v' of p(v' | v) exp(l_C(v')) / 2 ) (SR3)
//
// l_C is taken over kPixelCorrelation, and within kMostOfCell of its best; L over the number of
// pictures, as each is in so many of the drive's likelihoods. Without ground all is something else,
// with any v'. Reference: Neidell & Taner (1971), semblance.
#ifndef EGOSIEVE_VISION_TRAJECTORY_GROUND_SEARCH_H_
#define EGOSIEVE_VISION_TRAJECTORY_GROUND_SEARCH_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/evidence/pinhole.h"
#include "vision/trajectory/ground_speed.h"

namespace egosieve::vision {

struct GroundPicture {
  cv::Mat grey;                                            // CV_8UC1
  double seconds = 0.0;                                    // later than the first; of it 0
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // from the first: R_k
};

// The rotation by `share` of a rotation's angle.
Eigen::Matrix3d PartOfRotation(const Eigen::Matrix3d& rotation, double share);

struct GroundSearchView {
  std::vector<GroundPicture> pictures;                    // two or more, of one size
  Eigen::Vector3d direction = -Eigen::Vector3d::UnitZ();  // tau, a unit vector
  Pinhole camera;
  cv::Mat1b ignored;  // ignored_area.h: the own vehicle
};

class GroundSearch {
 public:
  // Speeds of what is not the road: the ground's, and these, heights per second.
  static constexpr std::array kOtherSpeeds = {-20.0, -12.0, -6.0, -3.0, -1.5, 0.0, 0.3};
  static constexpr int kAllSpeeds = kSpeeds + static_cast<int>(kOtherSpeeds.size());
  using AllSpeeds = Eigen::Array<double, kAllSpeeds, 1>;

  // Of `most_places` places at most.
  explicit GroundSearch(GroundSearchView view, size_t most_places = 1500);

  // For tau, a unit vector; those of two directions can be compared. All equal where the camera
  // does not move forward or back, and where nothing changed.
  SpeedLikelihood Likelihood(const Eigen::Vector3d& direction) const;

 private:
  // Of a cell at each speed: sums of squares of the values, and of those about their places' means.
  struct CellSums {
    AllSpeeds squares = AllSpeeds::Zero(), about_means = AllSpeeds::Zero();
    AllSpeeds values = AllSpeeds::Zero(), places = AllSpeeds::Zero();

    AllSpeeds LogRatios(double noise_variance) const;
  };

  void FindPlaces(size_t most_places);
  void Add(cv::Point place, const Eigen::Vector3d& direction, const AllSpeeds& speeds,
           CellSums& sums) const;
  std::vector<CellSums> SumCells(const Eigen::Vector3d& direction) const;

  GroundSearchView view_;
  std::vector<cv::Mat> changes_;   // CV_8UC1
  std::vector<cv::Point> places_;  // in the first picture
  double noise_ = 0.0;             // grey levels
};

// Of the view's own direction.
SpeedLikelihood LikelihoodOfSpeeds(const GroundSearchView& view);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_TRAJECTORY_GROUND_SEARCH_H_
