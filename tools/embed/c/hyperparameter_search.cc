#include "tools/embed/c/hyperparameter_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/not_positive_definite.h"
#include "gp/model/inducing_points.h"
#include "gp/training/bounded_ascent.h"
#include "gp/training/laplace_approximation.h"
#include "gp/training/marginal_likelihood.h"
#include "gp/training/sparse_likelihood.h"
#include "tools/embed/c/call.h"

namespace egosieve::embed {
namespace {

constexpr double kMinusInfinity = -std::numeric_limits<double>::infinity();
constexpr int kSparseRounds = 8;
constexpr double kNugget = 1e-10;   // of sigma_f^2
constexpr double kLeastRise = 0.1;  // of J by another choice of inducing inputs, nats
constexpr double kWidth = 20.0;     // of the restarts around theta_0, a factor

// `size` of the points, in their order; all if `size` is 0 or exceeds their number.
gp::PointSet DrawSubset(const gp::Observations& data, int64_t size, uint64_t seed) {
  const int64_t n = data.size();
  std::vector<int64_t> rows(n);
  std::iota(rows.begin(), rows.end(), 0);
  if (size > 0 && size < n) {
    std::mt19937_64 random(seed);
    for (int64_t i = 0; i < size; ++i) std::swap(rows[i], rows[i + random() % (n - i)]);
    rows.resize(size);
    std::sort(rows.begin(), rows.end());
  }
  return gp::PointsInRows(data, rows);
}

// J, with a count of its evaluations; -infinity if K is not positive definite with any jitter.
struct Objective {
  kernels::Context& context;
  const gp::Hyperparameters& kind;
  const gp::Observations& data;
  const egosieve_optimize_options& options;
  const std::optional<gp::SparseModelOptions>& sparse;  // only for a sparse model
  const bool of_classes;
  std::vector<double> inducing = {};
  double nugget = 0.0;  // of sigma_f^2, at least, that is added to sigma_n^2
  int64_t evaluations = 0;

  // A sparse model's inducing inputs, by the hyperparameters theta.
  void ChooseInducing(const std::vector<double>& theta) {
    if (!sparse.has_value()) return;
    inducing =
        Take(gp::ChooseInducingInputs(context, Take(gp::FromLogarithms(kind, theta)).covariance,
                                      data.inputs, sparse->inducing_points));
  }

  // sigma_n with what was added to it.
  double NoiseWithNugget(const gp::Hyperparameters& there) const {
    const double signal = there.covariance.signal_stddev;
    return std::sqrt(there.noise_variance() + nugget * signal * signal);
  }

  // gradient: null if it is not wanted; zeros where J is -infinity.
  double operator()(const std::vector<double>& theta, std::vector<double>* gradient) {
    if (options.should_stop != nullptr && options.should_stop(options.stop_argument) != 0) {
      Check(absl::CancelledError("the optimisation was stopped"));
    }
    ++evaluations;
    if (gradient != nullptr) gradient->assign(theta.size(), 0.0);
    gp::Hyperparameters there = Take(gp::FromLogarithms(kind, theta));
    const auto order =
        gradient == nullptr ? gp::LikelihoodOrder::kValue : gp::LikelihoodOrder::kValueAndGradient;
    const double own = there.noise_variance();
    there.noise_stddev = NoiseWithNugget(there);
    const double noise = there.noise_variance();
    const double unit = gp::LargestPriorVariance(there.covariance, data.inputs);
    for (std::optional<double> jitter = 0.0; jitter.has_value();
         jitter = sparse.has_value() ? std::nullopt : gp::NextJitter(*jitter, unit)) {
      if (*jitter > 0.0) there.noise_stddev = std::sqrt(noise + *jitter);
      absl::StatusOr<gp::MarginalLikelihood> likelihood = Likelihood(there, order);
      if (gp::IsNotPositiveDefinite(likelihood.status())) continue;
      Check(likelihood.status());
      if (gradient != nullptr) {
        *gradient = std::move(likelihood->gradient);
        // Of log(sigma_n^2 + nugget + jitter) / 2, of which sigma_n and sigma_f have their shares.
        const double of_noise = gradient->back() / (noise + *jitter);
        gradient->back() = of_noise * own;
        (*gradient)[gradient->size() - 2] += of_noise * (noise - own);
      }
      return likelihood->value;
    }
    return kMinusInfinity;
  }

  absl::StatusOr<gp::MarginalLikelihood> Likelihood(const gp::Hyperparameters& there,
                                                    gp::LikelihoodOrder order) const {
    if (of_classes) {
      const absl::Span<const double> labels(data.targets.data, data.targets.rows);
      auto laplace = gp::ApproximateByLaplace(context, there.covariance,
                                              {data.inputs, labels, data.noise_variances}, order);
      if (!laplace.ok()) return laplace.status();  // not positive definite: more jitter
      if (!laplace->gradient.empty()) laplace->gradient.push_back(0.0);
      return gp::MarginalLikelihood{laplace->log_likelihood, std::move(laplace->gradient)};
    }
    if (!sparse.has_value()) {
      return gp::ComputeMarginalLikelihood(context, there, data, order);
    }
    const int64_t count = static_cast<int64_t>(inducing.size()) / data.inputs.cols;
    return gp::ComputeSparseLikelihood(context, there, data,
                                       {inducing.data(), count, data.inputs.cols}, order, *sparse);
  }
};

// The ascent from theta; of a sparse model in rounds, with inducing inputs chosen in each.
gp::AscentResult AscendFrom(std::vector<double> theta, Objective& objective,
                            const gp::HyperparameterBounds& bounds,
                            const egosieve_optimize_options& options, bool is_sparse) {
  gp::AscentOptions ascent;
  ascent.steps = options.gradient_steps;
  ascent.tolerance = options.tolerance;
  const gp::ValueAndGradient f = [&](const std::vector<double>& at, std::vector<double>& gradient) {
    return objective(at, &gradient);
  };
  gp::AscentResult best;
  for (int round = 0; round < (is_sparse ? kSparseRounds : 1); ++round) {
    objective.ChooseInducing(theta);
    gp::AscentResult found = Take(gp::Ascend(f, theta, bounds, ascent));
    if (is_sparse) {  // with the inputs that the model will choose
      objective.ChooseInducing(found.theta);
      found.value = objective(found.theta, nullptr);
    }
    const bool rises = found.value > best.value + kLeastRise || round == 0;
    if (found.value > best.value || round == 0) best = found;
    if (!rises) break;
    theta = std::move(found.theta);
  }
  return best;
}

// 1 if it is 0 or not finite.
double PositiveRoot(double square) {
  const double root = std::sqrt(square);
  return root > 0.0 && std::isfinite(root) ? root : 1.0;
}

// Root mean square of column d around its mean. weights: of the rows; empty: all 1.
double SpreadOf(kernels::ConstMatrixView<double> inputs, int64_t d,
                absl::Span<const double> weights) {
  const auto weight = [&](int64_t i) { return weights.empty() ? 1.0 : weights[i]; };
  double total = 0.0, mean = 0.0, square = 0.0;
  for (int64_t i = 0; i < inputs.rows; ++i) total += weight(i);
  for (int64_t i = 0; i < inputs.rows; ++i) mean += weight(i) * inputs(i, d) / total;
  for (int64_t i = 0; i < inputs.rows; ++i) {
    square += weight(i) * (inputs(i, d) - mean) * (inputs(i, d) - mean) / total;
  }
  return PositiveRoot(square);
}

// Root mean square of the targets; around the mean of each output if `centred`.
double SizeOf(kernels::ConstMatrixView<double> targets, bool centred) {
  const double count = static_cast<double>(targets.rows * targets.cols);
  double square = 0.0;
  for (int64_t c = 0; c < targets.cols; ++c) {
    double mean = 0.0;
    for (int64_t i = 0; centred && i < targets.rows; ++i) mean += targets(i, c) / targets.rows;
    for (int64_t i = 0; i < targets.rows; ++i) {
      square += (targets(i, c) - mean) * (targets(i, c) - mean);
    }
  }
  return PositiveRoot(square / count);
}

// theta_0 and the default bounds.
struct Ranges {
  std::vector<double> start;
  gp::HyperparameterBounds bounds;
};

Ranges RangesOf(const gp::Hyperparameters& kind, const gp::Observations& data, bool of_classes) {
  const kernels::ConstMatrixView<double>& inputs = data.inputs;
  Ranges ranges;
  const auto add = [&](double start, double lower, double upper) {
    ranges.start.push_back(std::log(start));
    ranges.bounds.lower.push_back(std::log(lower));
    ranges.bounds.upper.push_back(std::log(upper));
  };
  std::vector<double> spreads;
  for (int64_t d = 0; d < inputs.cols; ++d) {
    spreads.push_back(
        SpreadOf(inputs, d, of_classes ? data.noise_variances : absl::Span<const double>()));
  }
  using Unit = kernels::ScaleGroup::Unit;
  for (const kernels::ScaleGroup& group : kind.covariance.function.description().scale_groups()) {
    std::vector<double> own;
    for (const int64_t column : group.columns) own.push_back(spreads[column]);
    if (own.empty()) own = spreads;
    const double root = std::sqrt(static_cast<double>(own.size()));  // distances grow with it
    if (!group.per_input) own = {*std::max_element(own.begin(), own.end())};
    for (const double spread : own) {
      switch (group.unit) {
        case Unit::kNone:
          add(1.0, 1e-5, 1e5);
          break;
        case Unit::kInput:
          add(0.5 * root * spread, 1e-4 * spread, 1e6 * spread);
          break;
        case Unit::kInverseInput:
          add(2.0 / (root * spread), 1e-6 / spread, 1e4 / spread);
          break;
      }
    }
  }
  if (of_classes) {
    add(1.0, 1e-3, 300.0);
    add(kind.noise_stddev, kind.noise_stddev, kind.noise_stddev);
    return ranges;
  }
  const double size = SizeOf(data.targets, kind.mean != gp::MeanFunction::kZero);
  const double around_mean = std::clamp(SizeOf(data.targets, true), 1e-8 * size, size);
  add(size, 1e-3 * around_mean, 1e4 * size);
  add(0.1 * around_mean, 1e-5 * around_mean, 10.0 * size);
  return ranges;
}

// The given bounds, and the default ones widened to include `start`. Given values are positive.
gp::HyperparameterBounds BoundsOf(const egosieve_optimize_options& options,
                                  gp::HyperparameterBounds bounds, const std::vector<double>& start,
                                  bool of_classes) {
  const bool given = options.lower_bounds != nullptr || options.upper_bounds != nullptr;
  Require(!given || options.bound_count == static_cast<int64_t>(start.size()),
          "%d bounds; there are %d hyperparameters: the scales, sigma_f, sigma_n",
          options.bound_count, start.size());
  for (size_t t = 0; t < start.size(); ++t) {
    const bool is_fixed = of_classes && t + 1 == start.size();
    const auto logarithm = [&](const double* values, double otherwise) {
      return values == nullptr || is_fixed || std::isnan(values[t]) ? otherwise
                                                                    : std::log(values[t]);
    };
    double &lower = bounds.lower[t], &upper = bounds.upper[t];
    lower = logarithm(options.lower_bounds, std::min(lower, start[t]));
    upper = logarithm(options.upper_bounds, std::max(upper, start[t]));
    Require(lower <= upper && std::isfinite(lower) && std::isfinite(upper),
            "bounds of hyperparameter %d: %g to %g; they must be positive, finite and in order", t,
            std::exp(lower), std::exp(upper));
  }
  return bounds;
}

// theta_0 times random factors, within the bounds.
std::vector<double> RandomStart(const std::vector<double>& theta_0,
                                const gp::HyperparameterBounds& bounds, std::mt19937_64& random) {
  std::vector<double> theta = theta_0;
  for (size_t t = 0; t < theta.size(); ++t) {
    const double lower = std::max(bounds.lower[t], theta_0[t] - std::log(kWidth));
    const double upper = std::min(bounds.upper[t], theta_0[t] + std::log(kWidth));
    const double share = static_cast<double>(random() >> 11) * 0x1p-53;
    theta[t] = lower + share * std::max(0.0, upper - lower);
  }
  bounds.Clamp(theta);
  return theta;
}

}  // namespace

SearchResult SearchHyperparameters(kernels::Context& context, const gp::Hyperparameters& start,
                                   const gp::Observations& data,
                                   const egosieve_optimize_options& options,
                                   const std::optional<gp::SparseModelOptions>& sparse,
                                   bool of_classes) {
  Require(options.subset_size >= 0 && options.subset_size != 1,
          "subset_size = %d; it must be 0 (all) or at least 2", options.subset_size);
  Require(options.restarts >= 0 && options.gradient_steps >= 0,
          "restarts = %d, gradient_steps = %d; neither may be negative", options.restarts,
          options.gradient_steps);
  Require(options.tolerance > 0.0, "tolerance = %g; it must be positive", options.tolerance);
  RequireState(data.size() >= 2,
               "hyperparameters need at least 2 points to be optimised on; there are %d",
               data.size());
  const gp::PointSet subset = DrawSubset(data, options.subset_size, options.seed);
  const gp::Observations drawn = subset.observations(data.inputs.cols);
  Ranges ranges = RangesOf(start, drawn, of_classes);
  std::vector<double> given = gp::ToLogarithms(start);
  const gp::HyperparameterBounds bounds = BoundsOf(options, ranges.bounds, given, of_classes);
  Objective objective{context, start, drawn, options, sparse, of_classes};
  SearchResult result;
  egosieve_optimize_result& account = result.account;
  objective.ChooseInducing(given);
  account.log_likelihood_at_start = objective(given, nullptr);
  const bool has_fixed_noise = bounds.lower.back() == bounds.upper.back();
  if (!has_fixed_noise) objective.nugget = kNugget;
  bounds.Clamp(given);
  bounds.Clamp(ranges.start);
  objective.ChooseInducing(ranges.start);
  const double of_data = objective(ranges.start, nullptr);
  std::vector<std::vector<double>> starts = {
      of_data > account.log_likelihood_at_start ? ranges.start : given};
  std::mt19937_64 random(options.seed);
  for (int i = 0; i < options.restarts; ++i) {
    starts.push_back(RandomStart(ranges.start, bounds, random));
  }
  gp::AscentResult best;
  for (const std::vector<double>& theta : starts) {
    gp::AscentResult found = AscendFrom(theta, objective, bounds, options, sparse.has_value());
    if (found.value > best.value) best = std::move(found);
  }
  if (!(best.value > kMinusInfinity)) {
    Check(gp::NotPositiveDefinite("the covariances are not positive definite at any start"));
  }
  result.hyperparameters = Take(gp::FromLogarithms(start, best.theta));
  if (!has_fixed_noise) {
    result.hyperparameters.noise_stddev = objective.NoiseWithNugget(result.hyperparameters);
  }
  account.points = drawn.size();
  account.log_likelihood = best.value;
  account.gradient_norm = best.gradient_norm;
  account.evaluations = objective.evaluations;
  account.converged = best.converged;
  for (size_t t = 0; t < best.theta.size(); ++t) {
    const bool is_free = bounds.lower[t] < bounds.upper[t];
    result.on_bound.push_back(
        is_free * ((best.theta[t] >= bounds.upper[t]) - (best.theta[t] <= bounds.lower[t])));
  }
  return result;
}

}  // namespace egosieve::embed
