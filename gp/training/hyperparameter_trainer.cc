#include "gp/training/hyperparameter_trainer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "absl/types/span.h"
#include "gp/calibration/leave_one_out.h"
#include "gp/linalg/not_positive_definite.h"
#include "gp/training/marginal_likelihood.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/splitmix.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

constexpr double kSmoothing = 0.2;      // weight of the newest value in running means
constexpr int64_t kMinimumPoints = 30;  // fewer points, or one class only: no training
constexpr int64_t kStepsPerRound = 2;   // after the first round
constexpr double kChangeDrop = 0.1;     // nats per point

// Independent seeds for every round and purpose.
uint64_t Mix(uint64_t seed, uint64_t round, uint64_t purpose) {
  return kernels::SplitMix(seed + kernels::kSplitMixStep * (2 * round + purpose + 1));
}

double LargestChange(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

// The running mean after one more check.
std::optional<double> MeanWith(std::optional<double> mean, double check) {
  if (!std::isfinite(check)) return mean;
  return mean.has_value() ? *mean + kSmoothing * (check - *mean) : check;
}

}  // namespace

absl::Status TrainerOptions::Validate() const {
  constexpr char kPositive[] = "be positive", kNotNegative[] = "not be negative";
  return kernels::CheckOptions({
      {"subset_size", subset_size, subset_size > 0, kPositive},
      {"annealing_subset_size", annealing_subset_size, annealing_subset_size > 0, kPositive},
      {"settled_interval", settled_interval, settled_interval > 0, kPositive},
      {"annealing_evaluations", annealing_evaluations, annealing_evaluations >= 0, kNotNegative},
      {"initial_gradient_steps", initial_gradient_steps, initial_gradient_steps >= 0, kNotNegative},
      {"rebuild_threshold", rebuild_threshold, rebuild_threshold >= 0.0, kNotNegative},
      {"settled_movement", settled_movement, settled_movement >= 0.0, kNotNegative},
      {"minimum_class_share", minimum_class_share,
       minimum_class_share >= 0.0 && minimum_class_share <= 0.5, "be in [0, 0.5]"},
      {"prior_stddev", prior_stddev, prior_stddev > 0.0, kPositive},
  });
}

absl::StatusOr<HyperparameterTrainer> HyperparameterTrainer::Create(
    const Hyperparameters& initial, const HyperparameterBounds& bounds,
    const TrainerOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(initial.Validate());
  EGOSIEVE_RETURN_IF_ERROR(bounds.Validate(initial.count()));
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  HyperparameterTrainer trainer;
  trainer.prior_centre_ = ToLogarithms(initial);
  bounds.Clamp(trainer.prior_centre_);
  trainer.bounds_ = bounds;
  trainer.options_ = options;
  trainer.state_.theta = trainer.prior_centre_;
  EGOSIEVE_ASSIGN_OR_RETURN(trainer.hyperparameters_,
                            FromLogarithms(initial, trainer.prior_centre_));
  return trainer;
}

PointSet HyperparameterTrainer::Draw(const Observations& points, int64_t size,
                                     uint64_t seed) const {
  const absl::Span<const double> targets(points.targets.data, points.size());
  return PointsInRows(points, StratifiedSample(targets, size, options_.minimum_class_share, seed));
}

absl::StatusOr<double> HyperparameterTrainer::Objective(kernels::Context& context,
                                                        const PointSet& subset,
                                                        const std::vector<double>& theta,
                                                        std::vector<double>* gradient) const {
  EGOSIEVE_ASSIGN_OR_RETURN(const Hyperparameters hyperparameters,
                            FromLogarithms(hyperparameters_, theta));
  const auto likelihood = ComputeMarginalLikelihood(
      context, hyperparameters, subset.observations(hyperparameters.covariance.input_dimension()),
      gradient == nullptr ? LikelihoodOrder::kValue : LikelihoodOrder::kValueAndGradient);
  if (IsNotPositiveDefinite(likelihood.status())) {
    if (gradient != nullptr) gradient->assign(theta.size(), 0.0);
    return -std::numeric_limits<double>::infinity();
  }
  EGOSIEVE_RETURN_IF_ERROR(likelihood.status());
  const double weight = 1.0 / static_cast<double>(subset.size());
  double value = likelihood->value;
  if (gradient != nullptr) *gradient = likelihood->gradient;
  for (size_t i = 0; i < theta.size(); ++i) {
    const double deviation = (theta[i] - prior_centre_[i]) / options_.prior_stddev;
    value -= 0.5 * deviation * deviation;
    if (gradient != nullptr) (*gradient)[i] -= deviation / options_.prior_stddev;
  }
  if (gradient != nullptr) {
    for (double& component : *gradient) component *= weight;
  }
  return weight * value;
}

absl::Status HyperparameterTrainer::Train(kernels::Context& context, const Observations& points) {
  EGOSIEVE_RETURN_IF_ERROR(points.Validate(hyperparameters_.covariance.input_dimension()));
  const double* targets = points.targets.data;
  const int64_t positives =
      std::count_if(targets, targets + points.size(), [](double y) { return y >= 0.0; });
  if (points.size() < kMinimumPoints || positives == 0 || positives == points.size()) {
    return absl::OkStatus();
  }
  TrainerState next = state_;
  const uint64_t round = static_cast<uint64_t>(state_.rounds);
  const bool anneals = state_.rounds == 0;
  const bool settled = !anneals && state_.smoothed_movement < options_.settled_movement;
  double check = 0.0;  // of a settled round
  if (anneals || settled) {
    const PointSet subset =
        Draw(points, options_.annealing_subset_size, Mix(options_.seed, round, 2));
    if (anneals) {
      const auto objective = [&](const std::vector<double>& theta) {
        return Objective(context, subset, theta, nullptr);
      };
      EGOSIEVE_ASSIGN_OR_RETURN(
          next.theta, Anneal(objective, next.theta, bounds_, options_.annealing_evaluations,
                             Mix(options_.seed, round, 1)));
    } else {
      EGOSIEVE_ASSIGN_OR_RETURN(check, Objective(context, subset, next.theta, nullptr));
    }
  }
  const bool changed = settled && state_.smoothed_objective.has_value() &&
                       check < *state_.smoothed_objective - kChangeDrop;
  next.smoothed_objective =
      settled && !changed ? MeanWith(state_.smoothed_objective, check) : std::nullopt;
  if (changed) next.smoothed_movement = 1.0;
  if (settled && !changed && state_.rounds_since_step + 1 < options_.settled_interval) {
    ++next.rounds_since_step;
  } else {
    const PointSet subset = Draw(points, options_.subset_size, Mix(options_.seed, round, 0));
    const int64_t steps = anneals ? options_.initial_gradient_steps : kStepsPerRound;
    std::vector<double> gradient;
    for (int64_t step = 0; step < steps; ++step) {
      EGOSIEVE_RETURN_IF_ERROR(Objective(context, subset, next.theta, &gradient).status());
      RpropStep(gradient, bounds_, next.optimiser, next.theta);
    }
    next.rounds_since_step = 0;
    const double movement = LargestChange(next.theta, state_.theta);
    next.smoothed_movement += kSmoothing * (movement - next.smoothed_movement);
  }
  ++next.rounds;
  EGOSIEVE_ASSIGN_OR_RETURN(hyperparameters_, FromLogarithms(hyperparameters_, next.theta));
  state_ = std::move(next);
  return absl::OkStatus();
}

bool HyperparameterTrainer::ShouldRebuild(const Hyperparameters& used) const {
  const std::vector<double> theta = ToLogarithms(used);
  if (theta.size() != state_.theta.size()) return true;
  return LargestChange(theta, state_.theta) > options_.rebuild_threshold;
}

absl::Status HyperparameterTrainer::Restore(const TrainerState& state) {
  EGOSIEVE_REQUIRE(InvalidArgument, bounds_.Contains(state.theta),
                   "theta has another size or lies outside the bounds");
  const size_t steps = state.optimiser.steps.size();
  EGOSIEVE_REQUIRE(InvalidArgument,
                   steps == state.optimiser.previous_gradient.size() &&
                       (steps == 0 || steps == state.theta.size()),
                   "the optimiser's steps have another size than theta");
  for (size_t i = 0; i < steps; ++i) {
    EGOSIEVE_REQUIRE(InvalidArgument,
                     state.optimiser.steps[i] > 0.0 && std::isfinite(state.optimiser.steps[i]) &&
                         std::isfinite(state.optimiser.previous_gradient[i]),
                     "the optimiser's steps are not finite and positive");
  }
  EGOSIEVE_REQUIRE(InvalidArgument,
                   state.rounds >= 0 && state.rounds_since_step >= 0 &&
                       state.smoothed_movement >= 0.0 &&
                       std::isfinite(state.smoothed_objective.value_or(0.0)),
                   "counts or smoothed values are negative or not numbers");
  EGOSIEVE_ASSIGN_OR_RETURN(hyperparameters_, FromLogarithms(hyperparameters_, state.theta));
  state_ = state;
  return absl::OkStatus();
}

}  // namespace egosieve::gp
