#include "vision/baselines/platt_sigmoid.h"

#include <algorithm>
#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace egosieve::vision {
namespace {

constexpr int kMaximumIterations = 100;
constexpr double kMinimumStep = 1e-10;
constexpr double kRidge = 1e-12;  // keeps the Hessian invertible
constexpr double kGradientBound = 1e-5;

// -t log p - (1 - t) log(1 - p) of (PS1) at z = A f + B.
double Loss(double target, double z) {
  return z >= 0.0 ? target * z + std::log1p(std::exp(-z))
                  : (target - 1.0) * z + std::log1p(std::exp(z));
}

class Problem {
 public:
  Problem(const std::vector<double>& decisions, const std::vector<uint8_t>& positive)
      : decisions_(decisions) {
    const double positives = static_cast<double>(
        std::count_if(positive.begin(), positive.end(), [](uint8_t p) { return p != 0; }));
    const double negatives = static_cast<double>(positive.size()) - positives;
    high_ = (positives + 1.0) / (positives + 2.0);
    low_ = 1.0 / (negatives + 2.0);
    for (const uint8_t p : positive) targets_.push_back(p != 0 ? high_ : low_);
    start_.a = 0.0;
    start_.b = std::log((negatives + 1.0) / (positives + 1.0));
  }

  const PlattSigmoid& start() const { return start_; }

  double Value(const PlattSigmoid& sigmoid) const {
    double sum = 0.0;
    for (size_t i = 0; i < decisions_.size(); ++i) {
      sum += Loss(targets_[i], sigmoid.a * decisions_[i] + sigmoid.b);
    }
    return sum;
  }

  struct Derivatives {
    double ga = 0.0, gb = 0.0;
    double haa = kRidge, hab = 0.0, hbb = kRidge;
  };

  Derivatives DerivativesAt(const PlattSigmoid& sigmoid) const {
    Derivatives d;
    for (size_t i = 0; i < decisions_.size(); ++i) {
      const double f = decisions_[i], p = sigmoid.Probability(f);
      const double slope = targets_[i] - p, curvature = p * (1.0 - p);
      d.ga += f * slope;
      d.gb += slope;
      d.haa += f * f * curvature;
      d.hab += f * curvature;
      d.hbb += curvature;
    }
    return d;
  }

 private:
  const std::vector<double>& decisions_;
  std::vector<double> targets_;
  double high_ = 1.0, low_ = 0.0;
  PlattSigmoid start_;
};

}  // namespace

double PlattSigmoid::Probability(double decision) const {
  const double z = a * decision + b;
  return z >= 0.0 ? std::exp(-z) / (1.0 + std::exp(-z)) : 1.0 / (1.0 + std::exp(z));
}

absl::StatusOr<PlattSigmoid> FitPlattSigmoid(const std::vector<double>& decisions,
                                             const std::vector<uint8_t>& positive) {
  if (decisions.size() != positive.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat(decisions.size(), " decision values and ", positive.size(), " classes"));
  }
  for (const double decision : decisions) {
    if (!std::isfinite(decision)) {
      return absl::InvalidArgumentError("a decision value is not finite");
    }
  }
  const Problem problem(decisions, positive);
  PlattSigmoid sigmoid = problem.start();
  double value = problem.Value(sigmoid);
  for (int iteration = 0; iteration < kMaximumIterations; ++iteration) {
    const Problem::Derivatives d = problem.DerivativesAt(sigmoid);
    if (std::abs(d.ga) < kGradientBound && std::abs(d.gb) < kGradientBound) break;
    const double determinant = d.haa * d.hbb - d.hab * d.hab;
    const double da = -(d.hbb * d.ga - d.hab * d.gb) / determinant;
    const double db = -(d.haa * d.gb - d.hab * d.ga) / determinant;
    const double descent = d.ga * da + d.gb * db;
    double step = 1.0;
    for (; step >= kMinimumStep; step *= 0.5) {
      const PlattSigmoid trial{sigmoid.a + step * da, sigmoid.b + step * db};
      const double trial_value = problem.Value(trial);
      if (trial_value < value + 1e-4 * step * descent) {
        sigmoid = trial;
        value = trial_value;
        break;
      }
    }
    if (step < kMinimumStep) break;
  }
  return sigmoid;
}

}  // namespace egosieve::vision
