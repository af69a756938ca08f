// What a motion that is known says: of its epipolar geometry, the ground, and single pairs.
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>

#include "vision/trajectory/ground_bound.h"
#include "vision/trajectory/two_view_motion.h"
#include "vision/trajectory/two_view_terms.h"

namespace egosieve::vision {
namespace {

using namespace two_view;  // NOLINT(google-build-using-namespace): its other half

constexpr double kRangeMeans = 12.0;  // of `nearest`: beyond it are 6 of a million static places
constexpr double kShowing = 3.0;      // deviations of a parallax that shows
// Farther from where a point at infinity would be, rays, neither the lens nor the look of a static
// place is known well enough to miss it there.
constexpr double kReach = 0.04;

// Of what is static, for the ground; 0: the ground says nothing.
double LeastParallax(const TwoViewMotion& motion, const State& state, const Vector2d& p) {
  const double least = ParallaxOf(LeastInverseDepth(motion.ground_slope, p, state.tau), state.tau);
  const double length = (state.tau.head<2>() - state.tau(2) * p).norm();
  return least * length <= kReach ? least : 0.0;
}

}  // namespace

TwoViewMotion Inverse(const TwoViewMotion& motion) {
  TwoViewMotion inverse = motion;
  inverse.rotation = motion.rotation.transpose();
  inverse.translation = -(inverse.rotation * motion.translation);
  inverse.rotation_covariance = inverse.rotation * motion.rotation_covariance * motion.rotation;
  return inverse;
}

RelativePose PoseOf(const TwoViewMotion& motion) {
  RelativePose pose;
  pose.outcome = motion.HasParallax() ? PoseOutcome::kFound : PoseOutcome::kNoTranslation;
  pose.rotation = motion.rotation;
  pose.translation = motion.translation;
  pose.rotation_covariance = motion.rotation_covariance;
  pose.noise_pixels = motion.noise_pixels;
  pose.parallax_pixels = motion.parallax_pixels;
  return pose;
}

Matrix3d FundamentalOf(const TwoViewMotion& motion, const Pinhole& camera) {
  return FundamentalOfPose(PoseOf(motion), camera);
}

Matrix3d RotationHomography(const TwoViewMotion& motion, const Pinhole& camera) {
  const Matrix3d k = camera.Matrix();
  return k * motion.rotation * k.inverse();
}

double GroundSlope(const std::vector<PointPair>& pairs, const TwoViewMotion& motion,
                   const Pinhole& camera) {
  if (!motion.HasParallax()) return 0.0;
  const State state = StateOf(motion);
  std::vector<BelowHorizon> places;
  for (const PointPair& pair : pairs) {
    const RayPair rays = {camera.Ray(pair.x1, pair.y1).head<2>(),
                          camera.Ray(pair.x2, pair.y2).head<2>()};
    const double below = Below(rays.p, state.tau);
    if (!(below > 0.0)) continue;
    const Terms terms = TermsOf(rays, state);
    if (terms.log_static < terms.log_moving || terms.s < kShowing * state.noise) continue;
    places.push_back({InverseDepthOf(terms.s / terms.length, state.tau), below});
  }
  return GroundSlopeOf(places);
}

PairLikelihood LikelihoodOf(const TwoViewMotion& motion, const Pinhole& camera,
                            const PointPair& pair, bool is_bounded) {
  const RayPair rays = {camera.Ray(pair.x1, pair.y1).head<2>(),
                        camera.Ray(pair.x2, pair.y2).head<2>()};
  const State state = StateOf(motion);
  const double least = is_bounded ? LeastParallax(motion, state, rays.p) : 0.0;
  const Terms terms = TermsOf(rays, state, least);
  PairLikelihood likelihood;
  likelihood.log_static = terms.log_static;
  likelihood.log_moving = terms.log_moving;
  likelihood.along = terms.s;
  likelihood.across = terms.c;
  likelihood.normal = Perpendicular(terms.u);
  const auto end = [&](double parallax) {
    const Vector2d there = rays.p + parallax * terms.length * terms.u;
    PairLikelihood::End end;
    end.place = camera.Project(motion.rotation * Vector3d(there(0), there(1), 1.0));
    end.scale = std::max(1.0 - state.tau(2) * parallax, 0.0);
    return end;
  };
  likelihood.farthest = end(least);
  likelihood.nearest = end(least + kRangeMeans * state.mean);
  return likelihood;
}

}  // namespace egosieve::vision
