#include "tools/embed/c/hyperparameter_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "gp/linalg/not_positive_definite.h"
#include "gp/model/inducing_points.h"
#include "gp/training/gradient_ascent.h"
#include "gp/training/marginal_likelihood.h"
#include "gp/training/simulated_annealing.h"
#include "kernels/base/status_macros.h"

namespace egosieve::embed {
namespace {

constexpr double kMinusInfinity = -std::numeric_limits<double>::infinity();

struct Subset {
  gp::PointSet points;
  int64_t dimension = 0;

  gp::Observations view() const { return points.observations(dimension); }
};

// `size` of the points, in their order; all if `size` is 0 or exceeds their number.
Subset DrawSubset(const gp::Observations& data, int64_t size, uint64_t seed) {
  const int64_t n = data.size();
  std::vector<int64_t> rows(n);
  std::iota(rows.begin(), rows.end(), 0);
  if (size > 0 && size < n) {
    std::mt19937_64 random(seed);
    for (int64_t i = 0; i < size; ++i) std::swap(rows[i], rows[i + random() % (n - i)]);
    rows.resize(size);
    std::sort(rows.begin(), rows.end());
  }
  Subset subset;
  subset.dimension = data.inputs.cols;
  for (const int64_t row : rows) {
    subset.points.Append(
        {data.inputs.rows_between(row, row + 1), data.targets.rows_between(row, row + 1),
         data.noise_variances.empty() ? data.noise_variances
                                      : data.noise_variances.subspan(row, 1)},
        0);
  }
  return subset;
}

// J, with a count of its evaluations; -infinity if K is not positive definite.
class Objective {
 public:
  // sparse, inducing (m x D): only for a sparse model.
  Objective(kernels::Context& context, const gp::Hyperparameters& kind, const Subset& subset,
            const std::optional<gp::SparseModelOptions>& sparse, std::vector<double> inducing)
      : context_(context),
        kind_(kind),
        subset_(subset),
        sparse_(sparse),
        inducing_(std::move(inducing)) {}

  absl::StatusOr<double> operator()(const std::vector<double>& theta,
                                    std::vector<double>* gradient) {
    ++evaluations_;
    EGOSIEVE_ASSIGN_OR_RETURN(const gp::Hyperparameters hyperparameters,
                              gp::FromLogarithms(kind_, theta));
    absl::StatusOr<gp::MarginalLikelihood> likelihood =
        Likelihood(hyperparameters, gradient == nullptr ? gp::LikelihoodOrder::kValue
                                                        : gp::LikelihoodOrder::kValueAndGradient);
    if (gp::IsNotPositiveDefinite(likelihood.status())) return kMinusInfinity;
    EGOSIEVE_RETURN_IF_ERROR(likelihood.status());
    const double share = 1.0 / static_cast<double>(subset_.points.size());
    if (gradient != nullptr) {
      *gradient = std::move(likelihood->gradient);
      for (double& slope : *gradient) slope *= share;
    }
    return likelihood->value * share;
  }

  int64_t evaluations() const { return evaluations_; }

 private:
  absl::StatusOr<gp::MarginalLikelihood> Likelihood(const gp::Hyperparameters& hyperparameters,
                                                    gp::LikelihoodOrder order) const {
    const gp::Observations data = subset_.view();
    if (!sparse_.has_value()) {
      return gp::ComputeMarginalLikelihood(context_, hyperparameters, data, order);
    }
    const int64_t count = static_cast<int64_t>(inducing_.size()) / subset_.dimension;
    return gp::ComputeSparseLikelihood(context_, hyperparameters, data,
                                       {inducing_.data(), count, subset_.dimension}, order,
                                       SparseObjectiveOf(*sparse_));
  }

  kernels::Context& context_;
  const gp::Hyperparameters& kind_;
  const Subset& subset_;
  const std::optional<gp::SparseModelOptions>& sparse_;
  const std::vector<double> inducing_;
  int64_t evaluations_ = 0;
};

struct Climb {
  std::vector<double> theta;
  double objective = kMinusInfinity;
  bool converged = false;
};

// Whether every coordinate has a small step or lies on its bound, where steps never shrink.
bool Settled(const std::vector<double>& theta, const gp::RpropState& state,
             const gp::HyperparameterBounds& bounds, double tolerance) {
  for (size_t t = 0; t < theta.size(); ++t) {
    const bool at_bound = theta[t] == bounds.lower[t] || theta[t] == bounds.upper[t];
    if (!at_bound && !(state.steps[t] < tolerance)) return false;
  }
  return true;
}

absl::StatusOr<Climb> ClimbFrom(std::vector<double> theta, Objective& objective,
                                const gp::HyperparameterBounds& bounds,
                                const SearchOptions& options) {
  const gp::RpropOptions rprop;
  gp::RpropState state;
  Climb best{theta, kMinusInfinity, false};
  std::vector<double> gradient;
  for (int step = 0; step <= options.gradient_steps; ++step) {
    EGOSIEVE_ASSIGN_OR_RETURN(const double value, objective(theta, &gradient));
    if (value > best.objective) {
      best.theta = theta;
      best.objective = value;
    }
    if (step == options.gradient_steps) break;
    if (!(value > kMinusInfinity)) {
      if (!(best.objective > kMinusInfinity)) break;
      theta = best.theta;
      for (double& size : state.steps) size = std::max(0.5 * size, rprop.minimum_step);
      std::fill(state.previous_gradient.begin(), state.previous_gradient.end(), 0.0);
      continue;
    }
    gp::RpropStep(gradient, bounds, rprop, state, theta);
    if (Settled(theta, state, bounds, options.tolerance)) {
      best.converged = true;
      break;
    }
  }
  return best;
}

double RootMeanSquare(absl::Span<const double> values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  const double root = std::sqrt(sum / static_cast<double>(std::max<size_t>(values.size(), 1)));
  return root > 0.0 && std::isfinite(root) ? root : 1.0;
}

// Root mean square of column d around its mean.
double SpreadOf(kernels::ConstMatrixView<double> inputs, int64_t d) {
  std::vector<double> column(inputs.rows);
  double mean = 0.0;
  for (int64_t i = 0; i < inputs.rows; ++i) mean += inputs(i, d) / inputs.rows;
  for (int64_t i = 0; i < inputs.rows; ++i) column[i] = inputs(i, d) - mean;
  return RootMeanSquare(column);
}

// Root mean square of the targets; around the mean of each output if `centred`.
double SizeOf(kernels::ConstMatrixView<double> targets, bool centred) {
  std::vector<double> values;
  for (int64_t c = 0; c < targets.cols; ++c) {
    double mean = 0.0;
    for (int64_t i = 0; centred && i < targets.rows; ++i) mean += targets(i, c) / targets.rows;
    for (int64_t i = 0; i < targets.rows; ++i) values.push_back(targets(i, c) - mean);
  }
  return RootMeanSquare(values);
}

}  // namespace

absl::Status SearchOptions::Validate() const {
  if (subset_size < 0 || subset_size == 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("subset_size = %d; it must be 0 (all) or at least 2", subset_size));
  }
  if (annealing_evaluations < 0 || gradient_steps < 0) {
    return absl::InvalidArgumentError(
        absl::StrFormat("annealing_evaluations = %d, gradient_steps = %d; neither may be negative",
                        annealing_evaluations, gradient_steps));
  }
  if (!(tolerance > 0.0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("tolerance = %g; it must be positive", tolerance));
  }
  return absl::OkStatus();
}

gp::SparseLikelihoodOptions SparseObjectiveOf(const gp::SparseModelOptions& options) {
  return {options.approximation == gp::SparseApproximation::kFitc ? gp::SparseObjective::kFitc
                                                                  : gp::SparseObjective::kVfe,
          options.relative_jitter};
}

gp::HyperparameterBounds BoundsForData(const gp::Hyperparameters& kind,
                                       const gp::Observations& data) {
  const kernels::ConstMatrixView<double>& inputs = data.inputs;
  gp::HyperparameterBounds bounds;
  const auto bound = [&](double lower, double upper) {
    bounds.lower.push_back(std::log(lower));
    bounds.upper.push_back(std::log(upper));
  };
  std::vector<double> spreads;
  for (int64_t d = 0; d < inputs.cols; ++d) spreads.push_back(SpreadOf(inputs, d));
  const double largest = *std::max_element(spreads.begin(), spreads.end());
  using Unit = kernels::ScaleGroup::Unit;
  for (const kernels::ScaleGroup& group : kind.covariance.function.description().scale_groups()) {
    for (int64_t d = 0; d < (group.per_input ? inputs.cols : 1); ++d) {
      const double spread = group.per_input ? spreads[d] : largest;
      switch (group.unit) {
        case Unit::kNone:
          bound(0.01, 100.0);
          break;
        case Unit::kInput:
          bound(0.01 * spread, 100.0 * spread);
          break;
        case Unit::kInverseInput:
          bound(0.01 / spread, 1000.0 / spread);
          break;
      }
    }
  }
  const double size = SizeOf(data.targets, kind.mean != gp::MeanFunction::kZero);
  bound(0.1 * size, 10.0 * size);
  bound(0.01 * size, 2.0 * size);
  return bounds;
}

absl::StatusOr<SearchResult> SearchHyperparameters(
    kernels::Context& context, const gp::Hyperparameters& start, const gp::Observations& data,
    const SearchOptions& options, const std::optional<gp::SparseModelOptions>& sparse) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (data.size() < 2) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "hyperparameters need at least 2 points to be optimised on; there are %d", data.size()));
  }
  const Subset subset = DrawSubset(data, options.subset_size, options.seed);
  gp::HyperparameterBounds bounds = BoundsForData(start, subset.view());
  std::vector<double> theta = gp::ToLogarithms(start);
  for (size_t t = 0; t < theta.size(); ++t) {
    bounds.lower[t] = std::min(bounds.lower[t], theta[t]);
    bounds.upper[t] = std::max(bounds.upper[t], theta[t]);
  }
  std::vector<double> inducing;
  if (sparse.has_value()) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        inducing, gp::ChooseInducingInputs(context, start.covariance, subset.view().inputs,
                                           sparse->inducing_points));
  }
  Objective objective(context, start, subset, sparse, std::move(inducing));
  EGOSIEVE_ASSIGN_OR_RETURN(const double at_start, objective(theta, nullptr));
  if (options.annealing_evaluations > 0) {
    gp::AnnealingOptions annealing;
    annealing.evaluations = options.annealing_evaluations;
    annealing.seed = options.seed;
    EGOSIEVE_ASSIGN_OR_RETURN(
        gp::AnnealingResult annealed,
        gp::Anneal([&](const std::vector<double>& at) { return objective(at, nullptr); }, theta,
                   bounds, annealing));
    theta = std::move(annealed.theta);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(Climb climb, ClimbFrom(std::move(theta), objective, bounds, options));
  if (!(climb.objective >= at_start)) {
    climb.theta = gp::ToLogarithms(start);
    climb.objective = at_start;
  }
  SearchResult result;
  EGOSIEVE_ASSIGN_OR_RETURN(result.hyperparameters, gp::FromLogarithms(start, climb.theta));
  result.points = subset.points.size();
  result.log_likelihood_at_start = at_start * static_cast<double>(result.points);
  result.log_likelihood = climb.objective * static_cast<double>(result.points);
  result.evaluations = objective.evaluations();
  result.converged = climb.converged;
  return result;
}

}  // namespace egosieve::embed
