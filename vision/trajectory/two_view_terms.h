// (TV2) to (TV5) of two_view_motion.h for one pair of rays. Internal to it.
#ifndef EGOSIEVE_VISION_TRAJECTORY_TWO_VIEW_TERMS_H_
#define EGOSIEVE_VISION_TRAJECTORY_TWO_VIEW_TERMS_H_

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "vision/trajectory/parallax_prior.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision::two_view {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The exponential prior is no narrower than this share of sigma: a Gaussian then, in effect.
inline constexpr double kLeastParallax = 0.02;
inline constexpr double kLeastShare = 0.2, kMostShare = 0.97;  // of pi
inline constexpr double kStartShare = 0.7;

struct RayPair {
  Vector2d p, q;  // third component 1
};

// What is estimated; tau as in (TV3).
struct State {
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d tau = Vector3d::UnitZ();
  double mean = 0.0, noise = 0.0, share = kStartShare, moving_scale = 0.0;
  double score = 0.0;
};

// (TV2) to (TV5) for one pair.
struct Terms {
  Vector2d d, u;
  double length = 0.0;  // |e|
  double s = 0.0, c = 0.0;
  double log_static = 0.0, log_moving = 0.0;
  ParallaxDensity parallax;
};

inline Vector2d Perpendicular(const Vector2d& u) { return {-u(1), u(0)}; }

inline Vector2d Derotated(const Matrix3d& rotation, const Vector2d& q) {
  const Vector3d ray = rotation.transpose() * Vector3d(q(0), q(1), 1.0);
  return ray.head<2>() / ray(2);
}

// least: of the inverse depths.
inline Terms TermsOf(const RayPair& pair, const State& state, double least = 0.0) {
  Terms terms;
  terms.d = Derotated(state.rotation, pair.q) - pair.p;
  const Vector2d e = state.tau.head<2>() - state.tau(2) * pair.p;
  terms.length = std::max(e.norm(), 1e-6);
  terms.u = e / terms.length;
  terms.s = terms.d.dot(terms.u);
  terms.c = terms.d.dot(Perpendicular(terms.u));
  const double sigma = state.noise;
  terms.parallax =
      EvaluateParallax(terms.s - least * terms.length,
                       std::max(state.mean * terms.length, kLeastParallax * sigma), sigma);
  terms.log_static = terms.parallax.log_density - 0.5 * (terms.c / sigma) * (terms.c / sigma) -
                     std::log(sigma * std::sqrt(2.0 * std::numbers::pi));
  const double scale = state.moving_scale;
  terms.log_moving = -std::log(2.0 * std::numbers::pi * scale * scale) -
                     1.5 * std::log1p(terms.d.squaredNorm() / (scale * scale));
  return terms;
}

// Log of the mixture, and the share of it that is static.
inline std::pair<double, double> Mix(const Terms& terms, double share) {
  const double a = terms.log_static + std::log(share);
  const double b = terms.log_moving + std::log1p(-share);
  const double top = std::max(a, b);
  const double sum = std::exp(a - top) + std::exp(b - top);
  return {top + std::log(sum), std::exp(a - top) / sum};
}

inline State StateOf(const TwoViewMotion& motion) {
  State state;
  state.rotation = motion.rotation;
  state.tau = motion.rotation.transpose() * motion.translation;
  state.mean = motion.mean_parallax;
  state.noise = motion.noise;
  state.share = std::clamp(motion.static_share, kLeastShare, kMostShare);
  state.moving_scale = motion.moving_scale;
  return state;
}

}  // namespace egosieve::vision::two_view

#endif  // EGOSIEVE_VISION_TRAJECTORY_TWO_VIEW_TERMS_H_
