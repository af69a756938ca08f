#include "gp/calibration/probabilistic_least_squares.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

constexpr double kInverseSqrtTwoPi = 0.3989422804014327;
constexpr double kLeastA = 0.3, kLargestA = 10.0, kLargestB = 5.0;
constexpr double kPrecisionOfLogA = 1.0 / (2.0 * 2.0);  // of the prior
constexpr int kMostSteps = 50;  // of Newton's method; each visits the points once or twice

double NormalDistribution(double z) { return 0.5 * std::erfc(-z * M_SQRT1_2); }

// The objective in (t, b), t = log a, with its gradient and the Gauss-Newton curvature, which
// treats z as linear in (t, b): log Phi is concave in z, so the curvature is positive.
struct Objective {
  double value = 0.0;
  double gradient[2] = {0.0, 0.0};
  double curvature[3] = {0.0, 0.0, 0.0};  // tt, tb, bb of the negative objective
};

class SquashProblem {
 public:
  SquashProblem(absl::Span<const double> means, absl::Span<const double> variances,
                absl::Span<const double> labels, double class_share)
      : means_(means), variances_(variances), labels_(labels) {
    double sum = 0.0;
    for (const double label : labels) sum += label;
    const double share = sum / static_cast<double>(std::max<size_t>(labels.size(), 1));
    if (class_share > 0.0 && share > 0.0 && share < 1.0) {
      weight_up_ = class_share / share;
      weight_down_ = (1.0 - class_share) / (1.0 - share);
    }
  }

  Objective Evaluate(double t, double b) const {
    const double a = std::exp(t);
    Objective result;
    for (size_t i = 0; i < means_.size(); ++i) {
      const double scale = 1.0 / std::sqrt(1.0 + a * a * variances_[i]);
      const double z = (a * means_[i] + b) * scale;
      const LogDistribution up = LogNormalDistribution(z);
      const LogDistribution down = LogNormalDistribution(-z);
      const double p = weight_up_ * labels_[i], q = weight_down_ * (1.0 - labels_[i]);
      result.value += (p > 0.0 ? p * up.value : 0.0) + (q > 0.0 ? q * down.value : 0.0);
      const double slope = p * up.derivative - q * down.derivative;
      const double bend =
          p * up.derivative * (up.derivative + z) + q * down.derivative * (down.derivative - z);
      const double z_t = a * scale * (means_[i] - z * a * variances_[i] * scale);
      const double z_b = scale;
      result.gradient[0] += slope * z_t;
      result.gradient[1] += slope * z_b;
      result.curvature[0] += bend * z_t * z_t;
      result.curvature[1] += bend * z_t * z_b;
      result.curvature[2] += bend * z_b * z_b;
    }
    result.value -= 0.5 * kPrecisionOfLogA * t * t;
    result.gradient[0] -= kPrecisionOfLogA * t;
    result.curvature[0] += kPrecisionOfLogA;
    return result;
  }

 private:
  absl::Span<const double> means_;
  absl::Span<const double> variances_;
  absl::Span<const double> labels_;
  double weight_up_ = 1.0, weight_down_ = 1.0;
};

absl::Status CheckPoints(absl::Span<const double> means, absl::Span<const double> variances,
                         absl::Span<const double> labels) {
  EGOSIEVE_REQUIRE(InvalidArgument,
                   means.size() == variances.size() && means.size() == labels.size(),
                   "%d means, %d variances and %d labels; the sizes must be equal", means.size(),
                   variances.size(), labels.size());
  for (size_t i = 0; i < means.size(); ++i) {
    EGOSIEVE_REQUIRE(
        InvalidArgument,
        std::isfinite(means[i]) && variances[i] >= 0.0 && std::isfinite(variances[i]) &&
            labels[i] >= 0.0 && labels[i] <= 1.0,
        "point %d: mean %g, variance %g, label %g; the mean must be finite, the variance finite "
        "and not negative, the label in [0, 1]",
        i, means[i], variances[i], labels[i]);
  }
  return absl::OkStatus();
}

}  // namespace

// Below -20 by the asymptotic series of Mills' ratio, Phi(z) = phi(z) / -z (1 - 1/z^2 + 3/z^4 -
// 15/z^6 + ...), whose sixth term is under 3e-12 there.
LogDistribution LogNormalDistribution(double z) {
  if (z > -20.0) {
    const double distribution = NormalDistribution(z);
    return {std::log(distribution), kInverseSqrtTwoPi * std::exp(-0.5 * z * z) / distribution};
  }
  const double s = 1.0 / (z * z);
  const double series = 1.0 - s * (1.0 - s * (3.0 - s * (15.0 - s * (105.0 - s * 945.0))));
  return {-0.5 * z * z + std::log(kInverseSqrtTwoPi) - std::log(-z) + std::log(series),
          -z / series};
}

double SquashParameters::Probability(double mean, double variance) const {
  return NormalDistribution((a * mean + b) / std::sqrt(1.0 + a * a * variance));
}

absl::StatusOr<SquashParameters> FitSquash(absl::Span<const double> means,
                                           absl::Span<const double> variances,
                                           absl::Span<const double> labels,
                                           const SquashParameters& start, double class_share) {
  EGOSIEVE_REQUIRE(InvalidArgument, class_share >= 0.0 && class_share < 1.0,
                   "class_share = %g; it must be in [0, 1)", class_share);
  EGOSIEVE_REQUIRE(InvalidArgument,
                   start.a > 0.0 && std::isfinite(start.a) && std::isfinite(start.b),
                   "start: a = %g, b = %g; a must be positive and both finite", start.a, start.b);
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(means, variances, labels));
  const double t_low = std::log(kLeastA), t_high = std::log(kLargestA), b_high = kLargestB;
  double t = std::clamp(std::log(start.a), t_low, t_high);
  double b = std::clamp(start.b, -b_high, b_high);
  const SquashProblem problem(means, variances, labels, class_share);
  Objective now = problem.Evaluate(t, b);
  double damping = 1e-3;  // Levenberg-Marquardt, relative to the curvature
  for (int step = 0; !means.empty() && step < kMostSteps; ++step) {
    // A coordinate whose gradient points out of its bound stays there.
    const bool hold_t =
        (t <= t_low && now.gradient[0] < 0.0) || (t >= t_high && now.gradient[0] > 0.0);
    const bool hold_b =
        (b <= -b_high && now.gradient[1] < 0.0) || (b >= b_high && now.gradient[1] > 0.0);
    const double tt = now.curvature[0] * (1.0 + damping) + 1e-12;
    const double bb = now.curvature[2] * (1.0 + damping) + 1e-12;
    const double tb = hold_t || hold_b ? 0.0 : now.curvature[1];
    const double g_t = hold_t ? 0.0 : now.gradient[0];
    const double g_b = hold_b ? 0.0 : now.gradient[1];
    const double determinant = tt * bb - tb * tb;
    const double next_t =
        std::clamp(t + std::clamp((bb * g_t - tb * g_b) / determinant, -2.0, 2.0), t_low, t_high);
    const double next_b = std::clamp(b + (tt * g_b - tb * g_t) / determinant, -b_high, b_high);
    if (std::abs(next_t - t) + std::abs(next_b - b) < 1e-10) break;
    const Objective next = problem.Evaluate(next_t, next_b);
    if (next.value >= now.value) {
      t = next_t;
      b = next_b;
      now = next;
      damping = std::max(1e-9, 0.1 * damping);
    } else {
      damping = 10.0 * damping;
      if (damping > 1e12) break;
    }
  }
  return SquashParameters{std::exp(t), b};
}

}  // namespace egosieve::gp
