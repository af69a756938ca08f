#include "tools/embed/c/learning_model.h"

#include <algorithm>
#include <new>
#include <optional>
#include <type_traits>

#include "gp/calibration/leave_one_out.h"
#include "kernels/base/argument_checks.h"

namespace egosieve::embed {
namespace {

constexpr double kLaplaceNoise = 1e-3;  // sigma_n, part of the noise variances 1 / W

// Labels are -1 and 1, or between. Values that are all 0 or 1 satisfy this, too, but almost always
// follow the other convention for labels; their probabilities would be wrong.
template <typename Model>
absl::Status LabelsOf(const Model& model, bool is_laplace) {
  if (is_laplace) return absl::OkStatus();
  const absl::Span<const double> targets = model.targets();
  EGOSIEVE_REQUIRE(FailedPrecondition, model.outputs() <= 1,
                   "probabilities are of one output; there are %d", model.outputs());
  int64_t zeros = 0, ones = 0;
  for (const double target : targets) {
    EGOSIEVE_REQUIRE(FailedPrecondition, target >= -1.0 && target <= 1.0,
                     "probabilities need every y in [-1, 1]; there is %g", target);
    zeros += target == 0.0;
    ones += target == 1.0;
  }
  EGOSIEVE_REQUIRE(FailedPrecondition,
                   zeros == 0 || zeros + ones < static_cast<int64_t>(targets.size()),
                   "every y is 0 or 1: probabilities need labels -1 and 1; give 2 y - 1");
  return absl::OkStatus();
}

absl::Status LabelsOf(const gp::IterativeModel&, bool /*is_laplace*/) { return gp::NeedsFactor(); }

absl::Status Renew(gp::ExactModel& model) { return model.Refactorize(); }
absl::Status Renew(gp::SparseModel& model) { return model.Refresh(); }
absl::Status Renew(gp::IterativeModel& model) { return model.Solve().status(); }

// What is not a sparse model has none.
template <typename Model>
std::optional<gp::SparseModelOptions> SparseOptionsOf(const Model& model) {
  if constexpr (std::is_same_v<Model, gp::SparseModel>) return model.options();
  return std::nullopt;
}

// devices: empty for the model's own.
template <typename Model>
std::shared_ptr<const gp::AdaptivePosterior> PosteriorOf(
    const Model& model, const gp::SquashParameters& squash,
    const kernels::DensePosteriorOptions& options, const kernels::Contexts& devices) {
  return std::make_shared<const gp::AdaptivePosterior>(
      Take(model.MakePosterior(squash, options, devices)), Take(model.MakeFloat64Posterior()));
}

}  // namespace

LearningModel::LearningModel(Model model, const kernels::DensePosteriorOptions& options)
    : context_(std::visit([](const auto& m) { return m.context(); }, model)),
      dimension_(std::visit([](const auto& m) { return m.input_dimension(); }, model)),
      options_(options),
      model_(std::move(model)) {}

std::shared_ptr<LearningModel> LearningModel::Create(
    std::shared_ptr<kernels::Context> context, gp::ModelFile file,
    const kernels::DensePosteriorOptions& options) {
  const auto make = [&]() -> Model {
    if (file.iterative) {
      return Take(gp::IterativeModel::Restore(std::move(context), file.model,
                                              file.iterative->options,
                                              std::move(file.iterative->alpha)));
    }
    if (!file.sparse) return Take(gp::ExactModel::Restore(std::move(context), file.model));
    return Take(gp::SparseModel::Restore(std::move(context), file.model, *file.sparse));
  };
  std::shared_ptr<LearningModel> model(new LearningModel(make(), options));
  model->squash_ = file.squash;
  const gp::SquashParameters uncalibrated;
  model->is_laplace_ = file.is_laplace;
  model->calibrated_ =
      file.is_laplace || file.squash.a != uncalibrated.a || file.squash.b != uncalibrated.b;
  model->is_renewed_ = true;
  model->annotation_ = std::move(file.annotations);
  return model;
}

void LearningModel::Changed() {
  posterior_ = nullptr;
  calibrated_ = is_laplace_ = is_renewed_ = false;
}

void LearningModel::Condition(const gp::Observations& added) {
  Apply([&](auto& model) {
    absl::Status status = absl::ResourceExhaustedError("memory ran out");
    try {
      status = model.AddObservations(added, 0);
    } catch (const std::bad_alloc&) {
    }
    if (std::is_same_v<decltype(model), gp::ExactModel&> && absl::IsResourceExhausted(status)) {
      const int64_t n = model.size() + added.size();
      status = absl::ResourceExhaustedError(absl::StrFormat(
          "%s: an exact model of %d points takes 8 n^2 bytes, %.1f GB; approximation \"iterative\" "
          "or \"dtc\" takes less",
          status.message(), n, 8e-9 * n * n));
    }
    Check(status);
  });
}

void LearningModel::Remove(std::vector<int64_t> rows) {
  std::sort(rows.begin(), rows.end());
  Apply([&](auto& model) {
    for (size_t i = 0; i < rows.size(); ++i) {
      Require(rows[i] >= 0 && rows[i] < model.size(), "rows: %d; the model has %d points", rows[i],
              model.size());
      Require(i == 0 || rows[i] != rows[i - 1], "rows: %d is there twice", rows[i]);
    }
    posterior_ = nullptr;  // so that the factor need not be copied for it
    Check(model.Remove(rows));
  });
}

void LearningModel::SetHyperparameters(std::vector<double> scales, double signal_stddev,
                                       double noise_stddev) {
  Apply([&](auto& model) {
    gp::Hyperparameters hyperparameters = model.hyperparameters();
    kernels::CovarianceParameters& covariance = hyperparameters.covariance;
    Require(scales.size() == covariance.scales.size(), "scale_count = %d; this model has %d scales",
            scales.size(), covariance.scales.size());
    covariance.scales = std::move(scales);
    covariance.signal_stddev = signal_stddev;
    hyperparameters.noise_stddev = noise_stddev;
    Check(model.SetHyperparameters(hyperparameters));
  });
}

SearchResult LearningModel::Optimize(const egosieve_optimize_options& options) {
  SearchResult result;
  Apply(
      [&](auto& model) {
        Require(
            !std::is_same_v<std::decay_t<decltype(model)>, gp::IterativeModel> ||
                options.subset_size > 0,
            "subset_size = 0, all points; an iterative model needs a subset, since the search is "
            "by the exact likelihood");
        result = SearchHyperparameters(*context_, model.hyperparameters(), model.observations(),
                                       options, SparseOptionsOf(model));
        Check(model.SetHyperparameters(result.hyperparameters));
      },
      /*renews=*/!std::holds_alternative<gp::IterativeModel>(model_));
  return result;
}

SearchResult LearningModel::Classify(const gp::LabelledInputs& data,
                                     const egosieve_optimize_options* search) {
  std::lock_guard lock(mutex_);
  const auto* exact = std::get_if<gp::ExactModel>(&model_);
  RequireState(exact != nullptr && exact->hyperparameters().mean == gp::MeanFunction::kZero,
               "classes need an exact model with the zero mean");
  SearchResult result;
  result.hyperparameters = exact->hyperparameters();
  result.hyperparameters.noise_stddev = kLaplaceNoise;
  if (search != nullptr) {
    result = SearchHyperparameters(*context_, result.hyperparameters,
                                   {data.inputs, data.labels, data.weights}, *search, std::nullopt,
                                   /*of_classes=*/true);
  }
  gp::LaplaceApproximation laplace = Take(gp::ApproximateByLaplace(
      *context_, result.hyperparameters.covariance, data, gp::LikelihoodOrder::kValue));
  if (search == nullptr) {
    result.account.log_likelihood_at_start = result.account.log_likelihood = laplace.log_likelihood;
    result.account.points = data.inputs.rows;
    result.account.evaluations = 1;
    result.on_bound.resize(result.hyperparameters.count());
  }
  for (double& variance : laplace.noise_variances) {
    variance = std::max(0.0, variance - kLaplaceNoise * kLaplaceNoise);
  }
  gp::ExactModel model = Take(gp::ExactModel::Create(context_, result.hyperparameters));
  Check(model.AddObservations({data.inputs, laplace.targets, laplace.noise_variances}, 0));
  model_ = std::move(model);
  Changed();
  squash_ = gp::SquashParameters{};
  calibrated_ = is_laplace_ = true;
  return result;
}

void LearningModel::Calibrate() {
  std::lock_guard lock(mutex_);
  const auto fit = [&](const auto& model) {
    RequireState(model.size() >= 2, "calibration needs at least 2 points; there are %d",
                 model.size());
    Check(LabelsOf(model, is_laplace_));
    if (calibrated_) return;
    std::vector<double> labels;
    for (const double target : model.targets()) labels.push_back(0.5 * (target + 1.0));
    const auto held_out = Take<gp::LeaveOneOut>(model.PredictLeaveOneOut());
    const double noise = model.hyperparameters().noise_variance();
    squash_ = Take(gp::FitSquash(held_out.mean, held_out.LatentVariance(noise), labels, {}));
    calibrated_ = true;
    posterior_ = nullptr;
  };
  std::visit(fit, model_);
}

void LearningModel::SetAnnotation(std::string annotation) {
  std::lock_guard lock(mutex_);
  annotation_ = std::move(annotation);
}

gp::ModelFile LearningModel::ToFile() {
  std::lock_guard lock(mutex_);
  gp::ModelFile file;
  const auto take = [&](auto& model) {
    if (!is_renewed_) {
      Check(Renew(model));
      posterior_ = nullptr;
      is_renewed_ = true;
    }
    file.model = model.State();
    file.sparse = SparseOptionsOf(model);
    if constexpr (requires { model.report(); }) {
      file.iterative = {model.options(), Take(model.Solve())->weights.alpha};
    }
  };
  std::visit(take, model_);
  file.squash = squash_;
  file.is_laplace = is_laplace_;
  file.annotations = annotation_;
  return file;
}

egosieve_gp_info LearningModel::Describe() const {
  egosieve_gp_info info{};
  const auto describe = [&](const auto& model) {
    const gp::Hyperparameters& hyperparameters = model.hyperparameters();
    const kernels::CovarianceParameters& covariance = hyperparameters.covariance;
    using kernels::CovarianceFunction;
    info.size = model.size();
    info.dimension = static_cast<int32_t>(dimension_);
    info.covariance = covariance.function == CovarianceFunction::kArcsine ? EGOSIEVE_ARCSINE
                      : covariance.function == CovarianceFunction::kSquaredExponential
                          ? EGOSIEVE_SQUARED_EXPONENTIAL
                          : EGOSIEVE_NAMED_COVARIANCE;
    info.scale_count = static_cast<int64_t>(covariance.scales.size());
    std::copy_n(covariance.scales.begin(),
                std::min<int64_t>(info.scale_count, EGOSIEVE_INFO_SCALES), info.scales);
    info.signal_stddev = covariance.signal_stddev;
    info.noise_stddev = hyperparameters.noise_stddev;
    if constexpr (requires { model.jitter(); }) info.jitter = model.jitter();
    info.squash_a = squash_.a;
    info.squash_b = squash_.b;
    info.has_labels = LabelsOf(model, is_laplace_).ok();
    info.outputs = model.outputs();
    info.mean = static_cast<egosieve_mean>(hyperparameters.mean);
    info.coefficients = gp::CoefficientCount(hyperparameters.mean, dimension_);
    if constexpr (requires { model.inducing_size(); }) {
      const bool is_fitc = model.options().approximation == gp::SparseApproximation::kFitc;
      info.approximation = is_fitc ? EGOSIEVE_FITC : EGOSIEVE_DTC;
      info.inducing_points = model.options().inducing_points;
      info.inducing_count = model.inducing_size();
    }
    if constexpr (requires { model.report(); }) {
      const auto report = model.report().value_or(gp::ConjugateGradientReport{-1, 0.0});
      info.approximation = EGOSIEVE_ITERATIVE;
      info.inducing_points = model.options().rank;
      info.tolerance = model.options().gradients.tolerance;
      info.iterations = report.iterations;
      info.residual = report.residual;
    }
  };
  Visit(describe);
  return info;
}

std::string LearningModel::annotation() const {
  std::lock_guard lock(mutex_);
  return annotation_;
}

DevicePosterior LearningModel::Posterior() {
  return Visit([&](const auto& model) {
    if (posterior_ == nullptr) posterior_ = PosteriorOf(model, squash_, options_, {});
    return DevicePosterior{context_, posterior_, LabelsOf(model, is_laplace_)};
  });
}

DevicePosterior LearningModel::PosteriorOn(const kernels::Contexts& devices) const {
  return Visit([&](const auto& model) {
    return DevicePosterior{devices.front(), PosteriorOf(model, squash_, options_, devices),
                           LabelsOf(model, is_laplace_), static_cast<int64_t>(devices.size())};
  });
}

}  // namespace egosieve::embed
