// The camera's motion between two pictures as one model: the rotation, and the translation as far
// as parallax determines it.
//
// With rays p, q (third component 1) of a point in the first and the second picture,
//
//   X_2 = R X_1 + t                                                                        (TV1)
//   d   = proj(R^T q) - p                   the flow that the rotation does not explain    (TV2)
//   e   = (tau_x - tau_z p_x, tau_y - tau_z p_y),  tau = R^T t,  |tau| = 1                 (TV3)
//
// A static point of inverse depth r (in units of 1 / |t|) has d = r e to first order in r, so with
// u = e / |e|, v perpendicular to u, s = d.u and c = d.v
//
//   p(d | static) = N(c; 0, sigma^2) integral N(s; r |e|, sigma^2) exp(-r / m) / m dr      (TV4)
//   p(d | moving) = (1 + |d|^2 / S^2)^(-3/2) / (2 pi S^2)                                  (TV5)
//
// The inverse depth is marginalised over an exponential prior of mean m, which is estimated. As m
// goes to zero, (TV4) becomes an isotropic Gaussian and the motion a pure rotation. A planar scene
// is only a special case of depths. So one likelihood covers both homography and fundamental
// matrix, which are often treated as separate models. A free depth costs likelihood where it is not
// needed, and negative depths are unlikely without a further term. The integral is the density of
// an exponentially modified Gaussian (parallax_prior.h).
//
// Estimation maximises the mean over the points of
//
//   log( pi p(d | static) + (1 - pi) p(d | moving) )                                       (TV6)
//
// by expectation maximisation with Gauss-Newton steps in the rotation (3) and in tau (2). It starts
// from kDirections translations spread evenly over the sphere, and the best kRefined of them are
// iterated to convergence. No random numbers are drawn. Where the direction of travel of the drive
// is known (travel_prior.h), its log density at tau, divided by the number of independent pairs, is
// added to (TV6): in traffic, vehicles that move with the camera can outnumber the static scene for
// seconds.
//
// Points that moved in the previous picture hardly count. Where p_i, the probability that point i
// moved, is above 1/2, pi of (TV6) is replaced for pair i by
//
//   pi_i = h (1 - p_i) + (1 - h) pi,   h = `memory`                                        (TV7)
//
// as if the state were kept with probability h and drawn anew otherwise. Points that were static
// keep pi, since any object may start to move.
//
// The likelihood of a single pair, from which labels are made, allows for static places that scatter
// more widely than sigma where the camera is hand-held (scatter.h):
//
//   p(d | static) = sum_k w_k (TV4) with s_k sigma in place of sigma                       (TV8)
//
// Cost: linear in the pairs, of which no more than kMostPairsUsed are used. References: Irani &
// Anandan (1998) on plane and parallax; Fermueller & Aloimonos (1998) on the search over directions
// of translation.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <vector>

#include "absl/types/span.h"
#include "vision/geometry/pinhole.h"
#include "vision/geometry/point_pair.h"
#include "vision/geometry/relative_pose.h"
#include "vision/trajectory/travel_prior.h"

namespace egosieve::vision {

// Whether a parallax is measurable: it is more than two deviations of a point's place.
inline bool IsParallax(double pixels, double noise_pixels) { return 2.0 * noise_pixels < pixels; }

struct TwoViewMotionOptions {
  TravelPrior travel;    // prior of tau, where known for the drive
  double memory = 0.97;  // h of (TV7), in [0, 1)
};

// The pose's translation means something where HasParallax(); its noise_pixels is sigma.
struct TwoViewMotion : RelativePose {
  bool found = false;            // false: too few pairs, the other fields are not valid
  double mean_parallax = 0.0;    // m, mean inverse depth times |t|; rays
  double noise = 0.0;            // sigma, rays
  double static_share = 0.0;     // pi
  double moving_scale = 0.0;     // S, rays
  double log_likelihood = 0.0;   // (TV6), densities per square pixel
  double parallax_pixels = 0.0;  // median of s over the static points
  // See ground_bound.h: the slope of the bound, and |t| in heights of the camera; 0: not known.
  // EstimateTwoViewMotion leaves them at 0; FindGround sets the second.
  double ground_slope = 0.0, ground_heights = 0.0;
  // Whether (TV8) holds: so for cameras that are on no vehicle. EstimateTwoViewMotion leaves it.
  bool scatters = false;
  // The drive's direction of travel, which defines the horizon. Set where the motion agrees with
  // it.
  std::optional<Eigen::Vector3d> travel;

  // Whether the translation is measurable by half of the static points.
  bool HasParallax() const { return found && IsParallax(parallax_pixels, noise_pixels); }
  // Deviation of the epipolar lines: sigma of one point divided by sqrt(kIndependentPairs / 5), for
  // the five parameters.
  double LineDeviationPixels() const { return std::sqrt(5.0 / kIndependentPairs) * noise_pixels; }

  // The errors of flow are correlated over an object, so all pairs together count as this many
  // independent ones.
  static constexpr double kIndependentPairs = 30.0;
};

// pairs: pixels, first picture to second. moved: p_i of (TV7), one per
// pair; empty: not known.
TwoViewMotion EstimateTwoViewMotion(const std::vector<PointPair>& pairs, const Pinhole& camera,
                                    const TwoViewMotionOptions& options,
                                    absl::Span<const float> moved = {});

// Sets ground_heights by the pairs from which the motion was estimated. Only static pairs with
// measurable parallax are used. Sets 0 where HasParallax() is false.
void FindGround(const std::vector<PointPair>& pairs, const Pinhole& camera, TwoViewMotion& motion);

// EstimateTwoViewMotion of a drive whose direction of travel, if known, is options.travel: with
// FindGround for a vehicle's camera, with scattering places for any other.
TwoViewMotion EstimateOnDrive(const std::vector<PointPair>& pairs, const Pinhole& camera,
                              const TwoViewMotionOptions& options,
                              absl::Span<const float> moved = {});

// One pair under a motion. Where the ground is known and bounds the depth, the integral of (TV4)
// begins at LeastInverseDepth.
struct PairLikelihood {
  double log_static = 0.0, log_moving = 0.0;          // (TV4) or (TV8), (TV5)
  double along = 0.0, across = 0.0;                   // s and c, rays
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  // v
  // The segment of the epipolar line on which static points of the same ray lie: from the farthest
  // point to the one where the prior of the inverse depth ends for practical purposes.
  struct End {
    Eigen::Vector2d place = Eigen::Vector2d::Zero();  // pixels
    double scale = 1.0;  // size in the second picture divided by that in the first
  };
  End farthest, nearest;
};
PairLikelihood LikelihoodOf(const TwoViewMotion& motion, const Pinhole& camera,
                            const PointPair& pair, bool is_bounded = true);

}  // namespace egosieve::vision
