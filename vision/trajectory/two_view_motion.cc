#include "vision/trajectory/two_view_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "kernels/base/parallel_for.h"
#include "vision/statistics/order_statistics.h"
#include "vision/trajectory/two_view_terms.h"

namespace egosieve::vision {
namespace {

using namespace two_view;  // NOLINT(google-build-using-namespace): its other half

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

constexpr size_t kFewestPairs = 20, kMostPairsUsed = 600;  // the latter drawn evenly
constexpr int kDirections = 60;                            // translations tried
constexpr size_t kRefined = 4;                             // of these, iterated to convergence
constexpr int kRefinedIterations = 12;
constexpr double kFloorPixels = 0.12, kStartPixels = 0.35, kMostPixels = 2.0;  // of sigma
constexpr double kLeastMovingScale = 8.0;                                      // of S, in sigma
constexpr double kLongestTurn = 0.2;                                           // per step, radians
// The search makes this many steps, on every kSearchEvery-th pair.
constexpr int kSearchIterations = 6;
constexpr size_t kSearchEvery = 3;
constexpr double kApart = 0.97;  // cosine between translations that count as different

// d (TV2) = -B dw for R <- R exp(w).
Eigen::Matrix<double, 2, 3> RotationFlow(const Vector2d& p) {
  Eigen::Matrix<double, 2, 3> b;
  b << -p(0) * p(1), 1.0 + p(0) * p(0), -p(1), -1.0 - p(1) * p(1), p(0) * p(1), p(0);
  return b;
}

// Two unit vectors that span the plane perpendicular to tau.
Eigen::Matrix<double, 3, 2> Tangents(const Vector3d& tau) {
  const Vector3d other = std::abs(tau(0)) < 0.7 ? Vector3d::UnitX() : Vector3d::UnitY();
  const Vector3d a = tau.cross(other).normalized();
  Eigen::Matrix<double, 3, 2> tangents;
  tangents << a, tau.cross(a);
  return tangents;
}

// The result of one pass over the pairs: the objective, the normal equations of its step in (w,
// tangents of tau), and the sums for the next pi and m.
struct Pass {
  double score = 0.0;
  Matrix5d normal = Matrix5d::Zero();
  Vector5d gradient = Vector5d::Zero();
  double static_sum = 0.0, parallax_sum = 0.0;
};

// The sums of a Pass, kept separately for each lane.
class LaneSums {
 public:
  explicit LaneSums(const State& state)
      : state_(state),
        tangents_(Tangents(state.tau)),
        precision_(1.0 / (state.noise * state.noise)) {}

  void Add(const RayPairs<kBlock>& pairs, const Lanes<kBlock>& counts) {
    using Values = Lanes<kBlock>;
    const Terms<kBlock> terms = TermsOf(pairs, state_);
    const Mixture<kBlock> mixture = Mix(pairs, terms, state_.share);
    const Values weight = counts * mixture.static_share;
    score_ += counts * mixture.log_density;
    static_ += weight;
    parallax_ += weight * terms.s.max(0.0) / terms.length;
    const Values xy = pairs.px * pairs.py;
    const Values across[3] = {-xy, 1.0 + pairs.px * pairs.px, -pairs.py};  // of RotationFlow
    const Values down[3] = {-1.0 - pairs.py * pairs.py, xy, pairs.px};
    const Values inverse_length = 1.0 / terms.length.max(1e-3);
    const Values third = pairs.px * terms.uy - pairs.py * terms.ux;
    Values ds[5], dc[5];
    for (int k = 0; k < 3; ++k) {
      ds[k] = -(terms.ux * across[k] + terms.uy * down[k]);
      dc[k] = terms.uy * across[k] - terms.ux * down[k];
    }
    for (int k = 0; k < 2; ++k) {
      // The rotation of u by a step of tau.
      const Values turn =
          (tangents_(1, k) * terms.ux - tangents_(0, k) * terms.uy + tangents_(2, k) * third) *
          inverse_length;
      ds[3 + k] = terms.c * turn;
      dc[3 + k] = -terms.s * turn;
    }
    const Values slope = weight * terms.parallax.slope, pull = precision_ * weight * terms.c;
    const Values curvature = weight * terms.parallax.curvature, narrow = precision_ * weight;
    for (int i = 0, k = 0; i < 5; ++i) {
      gradient_[i] += slope * ds[i] - pull * dc[i];
      const Values s_row = curvature * ds[i], c_row = narrow * dc[i];
      for (int j = 0; j <= i; ++j, ++k) normal_[k] += s_row * ds[j] + c_row * dc[j];
    }
  }

  Pass Total() const {
    Pass pass;
    pass.score = score_.sum();
    pass.static_sum = static_.sum();
    pass.parallax_sum = parallax_.sum();
    for (int i = 0, k = 0; i < 5; ++i) {
      pass.gradient(i) = gradient_[i].sum();
      for (int j = 0; j <= i; ++j, ++k) pass.normal(i, j) = pass.normal(j, i) = normal_[k].sum();
    }
    return pass;
  }

 private:
  static Lanes<kBlock> Zero() { return Lanes<kBlock>::Zero(); }

  const PreparedState state_;
  const Eigen::Matrix<double, 3, 2> tangents_;
  const double precision_;
  Lanes<kBlock> score_ = Zero(), static_ = Zero(), parallax_ = Zero();
  std::array<Lanes<kBlock>, 5> gradient_ = {Zero(), Zero(), Zero(), Zero(), Zero()};
  std::array<Lanes<kBlock>, 15> normal_ = {Zero(), Zero(), Zero(), Zero(), Zero(),
                                           Zero(), Zero(), Zero(), Zero(), Zero(),
                                           Zero(), Zero(), Zero(), Zero(), Zero()};
};

Pass Evaluate(const RayBlocks& pairs, const TravelPrior& travel, const State& state) {
  LaneSums sums(state);
  pairs.ForEachBlock([&](const RayPairs<kBlock>& block, const Lanes<kBlock>& counts, int) {
    sums.Add(block, counts);
  });
  Pass pass = sums.Total();
  const auto count = static_cast<double>(pairs.size());
  pass.score /= count;
  if (travel.IsKnown()) {
    const Eigen::Matrix<double, 3, 2> tangents = Tangents(state.tau);
    const double pull = travel.Membership(state.tau) * travel.concentration * count /
                        TwoViewMotion::kIndependentPairs;
    pass.score += travel.LogDensity(state.tau) / TwoViewMotion::kIndependentPairs;
    pass.gradient.tail<2>() += pull * tangents.transpose() * travel.direction;
    pass.normal.diagonal().tail<2>().array() += pull;
  }
  return pass;
}

void Apply(const Vector5d& step, State& state) {
  Vector3d turn = step.head<3>();
  if (turn.norm() > kLongestTurn) turn *= kLongestTurn / turn.norm();
  Vector2d shift = step.tail<2>();
  if (shift.norm() > kLongestTurn) shift *= kLongestTurn / shift.norm();
  state.rotation = state.rotation * RotationOf(turn);
  state.tau = (state.tau + Tangents(state.tau) * shift).normalized();
}

void UpdateMixture(const Pass& pass, size_t count, State& state) {
  state.mean = std::clamp(pass.parallax_sum / std::max(pass.static_sum, 1e-9), 1e-6, 10.0);
  state.share = std::clamp(pass.static_sum / static_cast<double>(count), kLeastShare, kMostShare);
}

// Damped Gauss-Newton steps (Levenberg-Marquardt); stops where damping does not help.
void Climb(const RayBlocks& pairs, const TravelPrior& travel, int iterations, State& state) {
  double damping = 1e-4;
  Pass pass = Evaluate(pairs, travel, state);
  for (int k = 0; k < iterations; ++k) {
    Matrix5d normal = pass.normal;
    normal.diagonal() *= 1.0 + damping;
    normal.diagonal().array() += 1e-9 * (1.0 + normal.diagonal().maxCoeff());
    State next = state;
    Apply(normal.ldlt().solve(pass.gradient), next);
    UpdateMixture(pass, pairs.size(), next);
    const Pass next_pass = Evaluate(pairs, travel, next);
    if (!(next_pass.score > pass.score)) {
      damping = std::max(damping * 10.0, 1e-2);
      if (damping > 1e3) break;
      continue;
    }
    const bool converged = next_pass.score - pass.score < 1e-6;
    state = next;
    pass = next_pass;
    damping *= 0.2;
    if (converged) break;
  }
  state.score = pass.score;
}

// Sets the noise by the weighted median of |c| over the static points, and the moving scale by the
// root mean square of the displacements of the others.
void UpdateScales(const RayBlocks& pairs, double floor, double most, State& state) {
  std::vector<std::pair<double, double>> across;
  double static_sum = 0.0, moving_sum = 0.0, moving_square = 0.0;
  const PreparedState prepared(state);
  pairs.ForEachBlock([&](const RayPairs<kBlock>& block, const Lanes<kBlock>&, int n) {
    const Terms<kBlock> terms = TermsOf(block, prepared);
    const Mixture<kBlock> mixture = Mix(block, terms, state.share);
    for (int k = 0; k < n; ++k) {
      const double weight = mixture.static_share(k);
      const double square = terms.dx(k) * terms.dx(k) + terms.dy(k) * terms.dy(k);
      across.emplace_back(std::abs(terms.c(k)), weight);
      static_sum += weight;
      moving_sum += 1.0 - weight;
      moving_square += (1.0 - weight) * std::min(square, 0.25);
    }
  });
  std::sort(across.begin(), across.end());
  double sum = 0.0;
  for (const auto& [value, weight] : across) {
    sum += weight;
    if (sum < 0.5 * static_sum) continue;
    state.noise = std::clamp(kMadToDeviation * value, floor, most);
    break;
  }
  state.moving_scale = std::max(kLeastMovingScale * state.noise,
                                0.7 * std::sqrt(moving_square / std::max(moving_sum, 1.0)));
}

// moved: p_i of (TV7), or empty.
RayBlocks Sample(const std::vector<PointPair>& pairs, absl::Span<const float> moved,
                 const Pinhole& camera, const TwoViewMotionOptions& options) {
  RayBlocks rays;
  const size_t count = std::min(pairs.size(), kMostPairsUsed);
  for (size_t k = 0; k < count; ++k) {
    const size_t i = k * pairs.size() / count;
    const PointPair& pair = pairs[i];
    StaticShare known;
    if (!moved.empty() && moved[i] > 0.5f) {
      known = {options.memory * (1.0 - moved[i]), 1.0 - options.memory};
    }
    rays.Add(camera.Ray(pair.x1, pair.y1).head<2>(), camera.Ray(pair.x2, pair.y2).head<2>(), known);
  }
  return rays;
}

// Fits a rotation without translation by weighted least squares. The scale of the weights shrinks,
// starting from the median residual. Returns the scale.
double FitRotation(const RayBlocks& pairs, double noise, Matrix3d& rotation) {
  double scale = noise;
  std::vector<double> lengths(pairs.size());
  for (int k = 0; k < 12; ++k) {
    for (size_t i = 0; i < pairs.size(); ++i) {
      lengths[i] = (Derotated(rotation, pairs.Q(i)) - pairs.P(i)).norm();
    }
    scale = std::max(noise, Median(lengths) * (k < 6 ? 1.5 : 1.0));
    Matrix3d normal = 1e-9 * Matrix3d::Identity();
    Vector3d right = Vector3d::Zero();
    for (size_t i = 0; i < pairs.size(); ++i) {
      const double z = lengths[i] / scale, weight = 1.0 / ((1.0 + z * z) * (1.0 + z * z));
      const Eigen::Matrix<double, 2, 3> b = RotationFlow(pairs.P(i));
      normal += weight * b.transpose() * b;
      right += weight * b.transpose() * (Derotated(rotation, pairs.Q(i)) - pairs.P(i));
    }
    rotation = rotation * RotationOf(normal.ldlt().solve(right));
  }
  return scale;
}

// Vector k of n unit vectors spread evenly over the sphere (Fibonacci lattice).
Vector3d Direction(int k, int n) {
  const double z = 1.0 - (2.0 * k + 1.0) / n, radius = std::sqrt(1.0 - z * z);
  const double angle = std::numbers::pi * (1.0 + std::sqrt(5.0)) * (k + 0.5);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

std::vector<State> Search(const RayBlocks& pairs, double noise, const TravelPrior& travel) {
  State start;
  const double scale = FitRotation(pairs, noise, start.rotation);
  std::vector<double> lengths;
  for (size_t i = 0; i < pairs.size(); ++i) {
    lengths.push_back((Derotated(start.rotation, pairs.Q(i)) - pairs.P(i)).norm());
  }
  start.noise = std::max(noise, 0.3 * scale);
  start.mean = std::max(MedianInPlace(lengths), noise);
  start.moving_scale =
      std::max(OfRankInPlace(lengths, lengths.size() * 85 / 100), kLeastMovingScale * start.noise);
  RayBlocks coarse;
  for (size_t i = 0; i < pairs.size(); i += kSearchEvery) {
    coarse.Add(pairs.P(i), pairs.Q(i), pairs.Share(i));
  }
  std::vector<State> states;
  if (travel.IsKnown()) states.emplace_back(start).tau = travel.direction;
  for (int k = 0; k < kDirections; ++k) states.emplace_back(start).tau = Direction(k, kDirections);
  kernels::ParallelFor(static_cast<int64_t>(states.size()),
                       [&](int64_t k) { Climb(coarse, travel, kSearchIterations, states[k]); });
  return states;
}

// The best states whose translations differ from those of better ones.
std::vector<State> BestApart(std::vector<State> states) {
  std::sort(states.begin(), states.end(),
            [](const State& a, const State& b) { return a.score > b.score; });
  std::vector<State> best;
  for (const State& state : states) {
    if (best.size() == kRefined) break;
    if (std::all_of(best.begin(), best.end(),
                    [&](const State& other) { return other.tau.dot(state.tau) < kApart; })) {
      best.push_back(state);
    }
  }
  return best;
}

void Converge(const RayBlocks& pairs, const Pinhole& camera, const TravelPrior& travel,
              State& state) {
  for (int round = 0; round < 3; ++round) {
    Climb(pairs, travel, kRefinedIterations, state);
    UpdateScales(pairs, kFloorPixels / camera.focal_pixels, kMostPixels / camera.focal_pixels,
                 state);
  }
  Climb(pairs, travel, kRefinedIterations, state);
}

TwoViewMotion MotionOf(const RayBlocks& pairs, const Pinhole& camera, const State& state) {
  TwoViewMotion motion;
  motion.found = true;
  motion.rotation = state.rotation;
  motion.translation = state.rotation * state.tau;
  motion.mean_parallax = state.mean;
  motion.noise = state.noise;
  motion.noise_pixels = state.noise * camera.focal_pixels;
  motion.static_share = state.share;
  motion.moving_scale = state.moving_scale;
  motion.log_likelihood = state.score - 2.0 * std::log(camera.focal_pixels);
  std::vector<double> parallaxes;
  const PreparedState prepared(state);
  pairs.ForEachBlock([&](const RayPairs<kBlock>& block, const Lanes<kBlock>&, int n) {
    const Terms<kBlock> terms = TermsOf(block, prepared);
    const Mixture<kBlock> mixture = Mix(block, terms, state.share);
    for (int k = 0; k < n; ++k) {
      if (mixture.static_share(k) >= 0.5) parallaxes.push_back(std::max(terms.s(k), 0.0));
    }
  });
  if (!parallaxes.empty()) {
    motion.parallax_pixels = MedianInPlace(parallaxes) * camera.focal_pixels;
  }
  return motion;
}

}  // namespace

TwoViewMotion EstimateTwoViewMotion(const std::vector<PointPair>& pairs, const Pinhole& camera,
                                    const TwoViewMotionOptions& options,
                                    absl::Span<const float> moved) {
  if (pairs.size() < kFewestPairs) return {};
  const RayBlocks rays = Sample(pairs, moved, camera, options);
  std::vector<State> states =
      BestApart(Search(rays, kStartPixels / camera.focal_pixels, options.travel));
  kernels::ParallelFor(static_cast<int64_t>(states.size()),
                       [&](int64_t k) { Converge(rays, camera, options.travel, states[k]); });
  const auto best =
      std::max_element(states.begin(), states.end(),
                       [](const State& a, const State& b) { return a.score < b.score; });
  TwoViewMotion motion = MotionOf(rays, camera, *best);
  if (options.travel.IsKnown() && options.travel.Membership(best->tau) > 0.5) {
    motion.travel = options.travel.direction;
  }
  return motion;
}

TwoViewMotion EstimateOnDrive(const std::vector<PointPair>& pairs, const Pinhole& camera,
                              const TwoViewMotionOptions& options, absl::Span<const float> moved) {
  TwoViewMotion motion = EstimateTwoViewMotion(pairs, camera, options, moved);
  if (options.travel.IsOfVehicle()) {
    FindGround(pairs, camera, motion);
  } else {
    motion.scatters = true;
  }
  return motion;
}

}  // namespace egosieve::vision
