#include "gp/training/bounded_ascent.h"

#include <Eigen/Core>
#include <cmath>
#include <deque>
#include <utility>

#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using Eigen::VectorXd;

constexpr double kSufficient = 1e-4;  // (PL3)
constexpr double kSteep = 0.9;        // of the slope at the start: a longer step is tried
constexpr double kShortest = 1e-12;   // t
constexpr double kLeastCurvature = 1e-10;
constexpr size_t kMemory = 10;    // pairs
constexpr double kLongest = 2.0;  // of a coordinate in one step with t = 1, in units of theta

struct Place {
  VectorXd theta, gradient;
  double value = -std::numeric_limits<double>::infinity();
};

class Ascent {
 public:
  Ascent(const ValueAndGradient& f, const HyperparameterBounds& bounds)
      : f_(f),
        lower_(VectorXd::Map(bounds.lower.data(), static_cast<int64_t>(bounds.lower.size()))),
        upper_(VectorXd::Map(bounds.upper.data(), static_cast<int64_t>(bounds.upper.size()))) {}

  absl::StatusOr<Place> At(const VectorXd& theta) const {
    Place place;
    place.theta = theta.cwiseMax(lower_).cwiseMin(upper_);
    std::vector<double> at(place.theta.begin(), place.theta.end()), gradient(at.size());
    EGOSIEVE_ASSIGN_OR_RETURN(place.value, f_(at, gradient));
    place.gradient = VectorXd::Map(gradient.data(), place.theta.size());
    if (std::isnan(place.value) || !place.gradient.allFinite()) {
      place.value = -std::numeric_limits<double>::infinity();
    }
    return place;
  }

  double ProjectedGradient(const Place& at) const {
    const VectorXd there = (at.theta + at.gradient).cwiseMax(lower_).cwiseMin(upper_);
    return (there - at.theta).cwiseAbs().maxCoeff();
  }

  // (PL2)
  VectorXd Direction(const Place& at) const {
    const VectorXd free =
        ((at.theta.array() <= lower_.array() && at.gradient.array() < 0.0) ||
         (at.theta.array() >= upper_.array() && at.gradient.array() > 0.0))
            .select(VectorXd::Zero(at.theta.size()), VectorXd::Ones(at.theta.size()));
    VectorXd d = at.gradient.cwiseProduct(free);
    std::vector<std::pair<VectorXd, VectorXd>> pairs;
    for (const auto& [s, y] : pairs_) {
      VectorXd step = s.cwiseProduct(free), change = y.cwiseProduct(free);
      if (Bends(step, change)) pairs.emplace_back(std::move(step), std::move(change));
    }
    std::vector<double> shares(pairs.size());
    for (size_t i = pairs.size(); i-- > 0;) {
      const auto& [s, y] = pairs[i];
      shares[i] = s.dot(d) / s.dot(y);
      d -= shares[i] * y;
    }
    if (!pairs.empty()) {
      const auto& [s, y] = pairs.back();
      d *= s.dot(y) / y.squaredNorm();
    }
    for (size_t i = 0; i < pairs.size(); ++i) {
      const auto& [s, y] = pairs[i];
      d += (shares[i] - y.dot(d) / s.dot(y)) * s;
    }
    const double longest = d.cwiseAbs().maxCoeff();
    const double allowed = pairs.empty() ? 0.25 * kLongest : kLongest;
    if (longest > allowed) d *= allowed / longest;
    return d;
  }

  // The next place by (PL3); `at` itself if no step of at least kShortest raises f.
  absl::StatusOr<Place> Step(const Place& at) const {
    const VectorXd d = Direction(at);
    for (double t = 1.0; t >= kShortest; t *= 0.5) {
      EGOSIEVE_ASSIGN_OR_RETURN(Place next, At(at.theta + t * d));
      if (!IsEnough(at, next)) continue;
      while (t >= 1.0 && t < 64.0 && next.gradient.dot(d) > kSteep * at.gradient.dot(d)) {
        t *= 2.0;
        EGOSIEVE_ASSIGN_OR_RETURN(Place farther, At(at.theta + t * d));
        if (!IsEnough(at, farther) || !(farther.value > next.value)) break;
        next = std::move(farther);
      }
      return next;
    }
    return at;
  }

  // The pairs are of minimising -f.
  void Remember(const Place& before, const Place& now) {
    VectorXd s = now.theta - before.theta, y = before.gradient - now.gradient;
    if (!Bends(s, y)) return;
    pairs_.emplace_back(std::move(s), std::move(y));
    if (pairs_.size() > kMemory) pairs_.pop_front();
  }

  bool remembers() const { return !pairs_.empty(); }
  void Forget() { pairs_.clear(); }

 private:
  static bool Bends(const VectorXd& s, const VectorXd& y) {
    return s.dot(y) > kLeastCurvature * s.norm() * y.norm();
  }
  static bool IsEnough(const Place& at, const Place& next) {
    const double rise = at.gradient.dot(next.theta - at.theta);
    return rise > 0.0 && next.value >= at.value + kSufficient * rise;
  }

  const ValueAndGradient& f_;
  const VectorXd lower_, upper_;
  std::deque<std::pair<VectorXd, VectorXd>> pairs_;  // s, y
};

}  // namespace

absl::StatusOr<AscentResult> Ascend(const ValueAndGradient& f, std::vector<double> theta,
                                    const HyperparameterBounds& bounds,
                                    const AscentOptions& options) {
  Ascent ascent(f, bounds);
  EGOSIEVE_ASSIGN_OR_RETURN(
      Place at, ascent.At(VectorXd::Map(theta.data(), static_cast<int64_t>(theta.size()))));
  AscentResult result;
  for (int step = 0;; ++step) {
    result.gradient_norm = std::isfinite(at.value) ? ascent.ProjectedGradient(at) : 0.0;
    result.converged = std::isfinite(at.value) && result.gradient_norm <= options.tolerance;
    if (result.converged || step == options.steps || !std::isfinite(at.value)) break;
    EGOSIEVE_ASSIGN_OR_RETURN(Place next, ascent.Step(at));
    if (!(next.value > at.value)) {
      if (!ascent.remembers()) break;
      ascent.Forget();  // the gradient itself is tried
      continue;
    }
    ascent.Remember(at, next);
    at = std::move(next);
  }
  result.theta.assign(at.theta.begin(), at.theta.end());
  result.value = at.value;
  return result;
}

}  // namespace egosieve::gp
