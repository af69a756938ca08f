// The own vehicle: everything that is fixed in the image during the whole drive while the scene
// moves. Bonnet, dashboard, mirror, black borders, reflections in the windscreen; also captions, logos
// and time stamps of hand-held clips.
//
// 1. Candidates. M is the median of pictures spread over the drive (fixed_pattern.h). A pixel with
//    contrast in M is a candidate if kShowingShare of the pictures show M there (FX2), and its
//    connected patch stays: in half of the pictures it shifts (FX3) by at most kMostShiftPixels. What
//    a camera follows shifts by more.
//
// 2. Proof. Distant points straight ahead are fixed in the image as well, and so are lines that
//    lead to them. From picture k to the next, k + 1, a static point at a candidate would move by
//    w_k + n_k r e_k, with r >= r_k its inverse depth. w_k is the effect of the camera's rotation,
//    e_k of its translation, both from picture k to a picture soon after it. n_k is the time to
//    picture k + 1, over the time to that picture. Only a part of this motion is visible at the
//    candidate, given by the structure tensor S of M, trace 1:
//
//      E = sum_k min(c, min_r |S^(1/2) (w_k + n_k r e_k)|^2 / (2 sigma^2))                  (OV2)
//
//    is the log-likelihood ratio of "fixed" against "static scene". The candidate is own vehicle if
//    E > kLeastProof; c is kMostOfPair, sigma kMostShiftPixels.
//    r_k is that of the ground (ground_bound.h, GB1). Its slope here is 0.3
//    times the median over static points below the horizon, because pictures so close in time show
//    no clear mode.                                                                         (OV3)
//
// 3. Patches of less than two windows are dropped. Blank parts that are enclosed by own vehicle and
//    the border of the image are added.
//
// Where the camera shakes on its mount (mount_shake.h), all of this is done once more in pictures that
// are steady on the vehicle. They are so by their own rotation: w_k is 0 then, and sigma has the
// deviation of the direction of travel, too. The own vehicle is where any picture has it.
//
// Pictures are reduced to at most 640 pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/own_vehicle/fixed_pattern.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision {

inline constexpr double kLeastProof = 12.0, kMostOfPair = 4.0;            // of E; c, of one pair
inline constexpr size_t kFewestPictures = kLeastProof / kMostOfPair + 1;  // that prove anything
inline constexpr size_t kFewestOfDrive = 12;   // with fewer there is no fixed pattern of a drive
inline constexpr double kLeastContrast = 2.5;  // deviation in the window, grey levels; below: blank

// Motion of the static scene between a picture and one soon after it.
struct PairWorld {
  TwoViewMotion motion;
  double times = 1.0;         // n of (OV2); not for rotation, because cameras turn to and fro
  double ground_slope = 0.0;  // g of (OV3)
  size_t picture = 0;         // k, among all pictures
};

// (OV3). pairs: the correspondences that `motion` was estimated from.
double LeastGroundSlope(const std::vector<PointPair>& pairs, const TwoViewMotion& motion,
                        const Pinhole& camera);

// Result of step 1, in pixels of the reduced picture.
struct FixedPlaces {
  enum Kind : uint8_t { kBlank = 0, kChanging = 1, kShifting = 2, kFixed = 3 };
  cv::Size image;  // of the original pictures
  cv::Mat1b kind;  // of the reduced picture; empty: too few pictures
  // 255 where a picture agrees with M, else 0; one per picture. Empty with too few for a drive.
  std::vector<cv::Mat1b> agreeing;
  cv::Mat1f s_xx, s_xy, s_yy;       // S
  cv::Mat1b median;                 // M; empty with too few for a drive
  std::vector<cv::Matx23f> shakes;  // of mount_shake.h, one per picture; empty: the mount holds

  // Whether the place, in pixels of the original picture, shows M in enough of the pictures, also if
  // it shifts: such places tell nothing of the camera's motion.
  bool IsFixed(double x, double y) const;
  // The same in this one of the pictures, which may have been shaken.
  bool IsFixedIn(size_t picture, double x, double y) const;
};

// reduced: ReducedPicture() of pictures of the size `image`.
FixedPlaces FindFixedPlaces(const std::vector<cv::Mat1b>& reduced, cv::Size image);

// The same for a camera that shakes on its mount; without places where the mount holds.
FixedPlaces FindFixedOnMount(const std::vector<cv::Mat1b>& reduced, cv::Size image);

// Step 2: 255 at the `candidates` with E > kLeastProof, else 0. both_agree: if given, 255 where
// both pictures of a pair agree with M, by PairWorld::picture. Then only these pairs count at a
// place, and n_k is 1.
cv::Mat1b ProvenPlaces(const cv::Mat1b& candidates, const FixedPlaces& places,
                       const std::vector<PairWorld>& worlds, const Pinhole& camera,
                       const std::vector<cv::Mat1b>* both_agree = nullptr);

// Enlarges a mask of the reduced picture to the size `image`; empty if no pixel is set.
cv::Mat1b OfTheImage(const cv::Mat1b& reduced, cv::Size image);

// Steps 2 and 3: 255 on the own vehicle, else 0, of the size of the original pictures; empty if
// there is none. Motions that were not found are skipped. camera: of the original pictures.
cv::Mat1b ProveOwnVehicle(const FixedPlaces& places, const std::vector<PairWorld>& worlds,
                          const Pinhole& camera);

}  // namespace egosieve::vision
