// Quantities of a known motion: its epipolar geometry, the ground, and likelihoods of pairs.
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/trajectory/ground_bound.h"
#include "vision/trajectory/scatter.h"
#include "vision/trajectory/two_view_motion.h"
#include "vision/trajectory/two_view_terms.h"

namespace egosieve::vision {
namespace {

using namespace two_view;  // NOLINT(google-build-using-namespace): its other half

constexpr double kRangeMeans = 12.0;  // of `nearest`: 6 in a million static points are beyond it
constexpr double kShowing = 3.0;      // least measurable parallax, in deviations
// Rays. At a larger distance from the position of a point at infinity, neither the lens nor the
// appearance of a static point is known well enough to judge that it is absent there.
constexpr double kReach = 0.04;

RayPairs<1> RaysOf(const Pinhole& camera, const PointPair& pair) {
  RayPairs<1> rays;
  rays.Set(0, camera.Ray(pair.x1, pair.y1).head<2>(), camera.Ray(pair.x2, pair.y2).head<2>());
  return rays;
}

// The least parallax |d| / |e| of a static point by the ground; 0: no bound.
double LeastParallax(const TwoViewMotion& motion, const State& state, const Vector2d& p) {
  const double depth = LeastInverseDepth(motion.ground_slope, p, motion.travel.value_or(state.tau));
  const double least = ParallaxOf(depth, state.tau);
  const double length = (state.tau.head<2>() - state.tau(2) * p).norm();
  return least * length <= kReach ? least : 0.0;
}

// (TV8)
double LogScatteredStatic(const Terms<1>& terms, const State& state, double least) {
  using Scales = Lanes<kScatterScales>;
  const Scales sigma = state.noise * ScatterScales();
  const double length = terms.length(0);
  const Scales mean = (kLeastParallax * sigma).max(state.mean * length);
  const Scales along = Scales::Constant(terms.s(0) - least * length);
  return LogScatterMean(EvaluateParallax<kScatterScales>(along, mean, sigma).log_density -
                        0.5 * (terms.c(0) / sigma).square() -
                        (std::sqrt(2.0 * std::numbers::pi) * sigma).log());
}

}  // namespace

void FindGround(const std::vector<PointPair>& pairs, const Pinhole& camera, TwoViewMotion& motion) {
  motion.ground_heights = 0.0;
  if (!motion.HasParallax()) return;
  const PreparedState state(StateOf(motion));
  std::vector<double> slopes;
  for (const PointPair& pair : pairs) {
    const RayPairs<1> rays = RaysOf(camera, pair);
    const double below = Below(rays.P(0), motion.travel.value_or(state.tau));
    if (!(below > 0.0)) continue;
    const Terms<1> terms = TermsOf(rays, state);
    if (terms.log_static(0) < terms.log_moving(0) || terms.s(0) < kShowing * state.noise) continue;
    slopes.push_back(InverseDepthOf(terms.s(0) / terms.length(0), state.tau) / below);
  }
  motion.ground_heights = GroundSlopeOf(slopes);
}

PairLikelihood LikelihoodOf(const TwoViewMotion& motion, const Pinhole& camera,
                            const PointPair& pair, bool is_bounded) {
  const RayPairs<1> rays = RaysOf(camera, pair);
  const Vector2d p = rays.P(0);
  const PreparedState state(StateOf(motion));
  const double least = is_bounded ? LeastParallax(motion, state, p) : 0.0;
  const Terms<1> terms = TermsOf(rays, state, least);
  const Vector2d u(terms.ux(0), terms.uy(0));
  PairLikelihood likelihood;
  likelihood.log_static =
      motion.scatters ? LogScatteredStatic(terms, state, least) : terms.log_static(0);
  likelihood.log_moving = terms.log_moving(0);
  likelihood.along = terms.s(0);
  likelihood.across = terms.c(0);
  likelihood.normal = Perpendicular(u);
  const auto end = [&](double parallax) {
    const Vector2d there = p + parallax * terms.length(0) * u;
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
