// (TV2) to (TV5) of two_view_motion.h for a few pairs of rays at a time. Internal to it.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "vision/trajectory/parallax_prior.h"
#include "vision/trajectory/two_view_motion.h"

namespace egosieve::vision::two_view {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The mean of the exponential prior is at least this share of sigma, where (TV4) is practically a
// Gaussian.
inline constexpr double kLeastParallax = 0.02;
inline constexpr double kLeastShare = 0.2, kMostShare = 0.97;  // bounds of pi
inline constexpr double kStartShare = 0.7;
inline constexpr int kBlock = 8;  // pairs evaluated together

// pi_i of a pair by (TV7): kept + renewed pi.
struct StaticShare {
  double kept = 0.0, renewed = 1.0;
};

// Rays of pairs, third components 1.
template <int kLanes>
struct RayPairs {
  Lanes<kLanes> px, py, qx, qy;
  // h (1 - p) and 1 - h where (TV7) applies, else 0 and 1.
  Lanes<kLanes> kept = Lanes<kLanes>::Zero(), renewed = Lanes<kLanes>::Ones();

  void Set(int lane, const Vector2d& p, const Vector2d& q, const StaticShare& share = {}) {
    kept(lane) = share.kept;
    renewed(lane) = share.renewed;
    px(lane) = p(0);
    py(lane) = p(1);
    qx(lane) = q(0);
    qy(lane) = q(1);
  }
  Vector2d P(int lane) const { return {px(lane), py(lane)}; }
  Vector2d Q(int lane) const { return {qx(lane), qy(lane)}; }
  StaticShare Share(int lane) const { return {kept(lane), renewed(lane)}; }
};

// Pairs in blocks. The last block is padded with copies of the last pair, which do not count.
class RayBlocks {
 public:
  void Add(const Vector2d& p, const Vector2d& q, const StaticShare& share = {}) {
    const int lane = static_cast<int>(size_ % kBlock);
    if (lane == 0) blocks_.emplace_back();
    for (int k = lane; k < kBlock; ++k) blocks_.back().Set(k, p, q, share);
    ++size_;
  }
  size_t size() const { return size_; }
  Vector2d P(size_t i) const { return blocks_[i / kBlock].P(static_cast<int>(i % kBlock)); }
  Vector2d Q(size_t i) const { return blocks_[i / kBlock].Q(static_cast<int>(i % kBlock)); }
  StaticShare Share(size_t i) const {
    return blocks_[i / kBlock].Share(static_cast<int>(i % kBlock));
  }

  // work(pairs, counts, n): counts is 1 for the block's first n pairs, else 0.
  template <typename Work>
  void ForEachBlock(const Work& work) const {
    Lanes<kBlock> counts = Lanes<kBlock>::Ones();
    for (size_t b = 0; b < blocks_.size(); ++b) {
      const int n = static_cast<int>(std::min<size_t>(kBlock, size_ - b * kBlock));
      counts.tail(kBlock - n).setZero();
      work(blocks_[b], counts, n);
    }
  }

 private:
  std::vector<RayPairs<kBlock>> blocks_;
  size_t size_ = 0;
};

// The quantities that are estimated; tau as in (TV3).
struct State {
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d tau = Vector3d::UnitZ();
  double mean = 0.0, noise = 0.0, share = kStartShare, moving_scale = 0.0;
  double score = 0.0;
};

// A state and the logarithms of the densities' normalisation, which are the same for all pairs.
struct PreparedState : State {
  explicit PreparedState(const State& given)
      : State(given),
        log_across(std::log(noise * std::sqrt(2.0 * std::numbers::pi))),
        log_moving_area(std::log(2.0 * std::numbers::pi * moving_scale * moving_scale)) {}

  double log_across, log_moving_area;
};

// (TV2) to (TV5).
template <int kLanes>
struct Terms {
  Lanes<kLanes> dx, dy, ux, uy;
  Lanes<kLanes> length;  // |e|
  Lanes<kLanes> s, c;
  Lanes<kLanes> log_static, log_moving;
  ParallaxDensity<kLanes> parallax;
};

inline Vector2d Perpendicular(const Vector2d& u) { return {-u(1), u(0)}; }

inline Vector2d Derotated(const Matrix3d& rotation, const Vector2d& q) {
  const Vector3d ray = rotation.transpose() * Vector3d(q(0), q(1), 1.0);
  return ray.head<2>() / ray(2);
}

// least: the least parallax |d| / |e| of a static point.
template <int kLanes>
Terms<kLanes> TermsOf(const RayPairs<kLanes>& pairs, const PreparedState& state,
                      double least = 0.0) {
  const Matrix3d& r = state.rotation;
  const auto turned = [&](int axis) -> Lanes<kLanes> {
    return r(0, axis) * pairs.qx + r(1, axis) * pairs.qy + r(2, axis);
  };
  const Lanes<kLanes> depth = turned(2);
  Terms<kLanes> terms;
  terms.dx = turned(0) / depth - pairs.px;
  terms.dy = turned(1) / depth - pairs.py;
  const Lanes<kLanes> ex = state.tau(0) - state.tau(2) * pairs.px;
  const Lanes<kLanes> ey = state.tau(1) - state.tau(2) * pairs.py;
  terms.length = (ex * ex + ey * ey).sqrt().max(1e-6);
  terms.ux = ex / terms.length;
  terms.uy = ey / terms.length;
  terms.s = terms.dx * terms.ux + terms.dy * terms.uy;
  terms.c = terms.dy * terms.ux - terms.dx * terms.uy;
  const double sigma = state.noise, scale = state.moving_scale;
  terms.parallax =
      EvaluateParallax<kLanes>(terms.s - least * terms.length,
                               (state.mean * terms.length).max(kLeastParallax * sigma), sigma);
  terms.log_static =
      terms.parallax.log_density - 0.5 * (terms.c / sigma).square() - state.log_across;
  terms.log_moving =
      -state.log_moving_area -
      1.5 * (1.0 + (terms.dx * terms.dx + terms.dy * terms.dy) / (scale * scale)).log();
  return terms;
}

// The mixture of the static and the moving density, and the posterior share of the static one.
template <int kLanes>
struct Mixture {
  Lanes<kLanes> log_density;
  Lanes<kLanes> static_share;
};

template <int kLanes>
Mixture<kLanes> Mix(const RayPairs<kLanes>& pairs, const Terms<kLanes>& terms, double share) {
  const Lanes<kLanes> prior = pairs.kept + pairs.renewed * share;
  const Lanes<kLanes> a = terms.log_static + prior.log();
  const Lanes<kLanes> b = terms.log_moving + (1.0 - prior).log();
  const Lanes<kLanes> lesser = (-(a - b).abs()).exp();
  const Lanes<kLanes> sum = 1.0 + lesser;
  return {a.max(b) + sum.log(), (a < b).select(lesser, 1.0) / sum};
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
