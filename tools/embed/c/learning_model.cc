#include "tools/embed/c/learning_model.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"

namespace egosieve::embed {
namespace {

constexpr double kLaplaceNoise = 1e-3;  // sigma_n, part of the noise variances 1 / W

// Labels are -1 and 1, or between. Values that are all 0 or 1 satisfy this, too, but almost always
// follow the other convention for labels; their probabilities would be wrong.
template <typename Model>
absl::Status CheckLabels(const Model& model, bool is_laplace) {
  if (is_laplace) return absl::OkStatus();
  const absl::Span<const double> targets = model.targets();
  if (model.outputs() > 1) {
    return absl::FailedPreconditionError(
        absl::StrFormat("probabilities are of one output; there are %d", model.outputs()));
  }
  int64_t zeros = 0, ones = 0;
  for (const double target : targets) {
    if (!(target >= -1.0 && target <= 1.0)) {
      return absl::FailedPreconditionError(
          absl::StrFormat("probabilities need every y in [-1, 1]; there is %g", target));
    }
    zeros += target == 0.0;
    ones += target == 1.0;
  }
  if (zeros > 0 && zeros + ones == static_cast<int64_t>(targets.size())) {
    return absl::FailedPreconditionError(
        "every y is 0 or 1: probabilities need labels -1 and 1; give 2 y - 1");
  }
  return absl::OkStatus();
}

absl::Status Renew(gp::ExactModel& model) { return model.Refactorize(); }
absl::Status Renew(gp::SparseModel& model) { return model.Refresh(); }

std::optional<gp::SparseModelOptions> SparseOptionsOf(const gp::ExactModel&) {
  return std::nullopt;
}
std::optional<gp::SparseModelOptions> SparseOptionsOf(const gp::SparseModel& model) {
  return model.options();
}

// devices: empty for the model's own.
template <typename Model>
absl::StatusOr<std::shared_ptr<const gp::AdaptivePosterior>> PosteriorOf(
    const Model& model, const gp::SquashParameters& squash,
    const kernels::DensePosteriorOptions& options, const kernels::Contexts& devices) {
  EGOSIEVE_ASSIGN_OR_RETURN(auto in_float32, model.MakePosterior(squash, options, devices));
  EGOSIEVE_ASSIGN_OR_RETURN(auto in_float64, model.MakeFloat64Posterior());
  return std::make_shared<const gp::AdaptivePosterior>(std::move(in_float32),
                                                       std::move(in_float64));
}

int64_t InducingSize(const gp::ExactModel&) { return 0; }
int64_t InducingSize(const gp::SparseModel& model) { return model.inducing_size(); }

}  // namespace

LearningModel::LearningModel(Model model, const kernels::DensePosteriorOptions& options)
    : context_(std::visit([](const auto& m) { return m.context(); }, model)),
      dimension_(std::visit([](const auto& m) { return m.input_dimension(); }, model)),
      options_(options),
      model_(std::move(model)) {}

absl::StatusOr<std::shared_ptr<LearningModel>> LearningModel::Create(
    std::shared_ptr<kernels::Context> context, const gp::Hyperparameters& hyperparameters,
    const std::optional<gp::SparseModelOptions>& sparse,
    const kernels::DensePosteriorOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (sparse.has_value()) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        gp::SparseModel model,
        gp::SparseModel::Create(std::move(context), hyperparameters, *sparse));
    return std::shared_ptr<LearningModel>(new LearningModel(std::move(model), options));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(gp::ExactModel model,
                            gp::ExactModel::Create(std::move(context), hyperparameters));
  return std::shared_ptr<LearningModel>(new LearningModel(std::move(model), options));
}

absl::StatusOr<std::shared_ptr<LearningModel>> LearningModel::FromFile(
    std::shared_ptr<kernels::Context> context, gp::ModelFile file) {
  std::shared_ptr<LearningModel> model;
  if (file.sparse.has_value()) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        gp::SparseModel sparse,
        gp::SparseModel::Restore(std::move(context), file.model, *file.sparse));
    model.reset(new LearningModel(std::move(sparse), {}));
  } else {
    EGOSIEVE_ASSIGN_OR_RETURN(gp::ExactModel exact,
                              gp::ExactModel::Restore(std::move(context), file.model));
    model.reset(new LearningModel(std::move(exact), {}));
  }
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
  calibrated_ = false;
  is_laplace_ = false;
  is_renewed_ = false;
}

absl::Status LearningModel::Condition(const gp::Observations& added) {
  std::lock_guard lock(mutex_);
  EGOSIEVE_RETURN_IF_ERROR(
      std::visit([&](auto& model) { return model.AddObservations(added, 0); }, model_));
  Changed();
  return absl::OkStatus();
}

absl::Status LearningModel::Remove(std::vector<int64_t> rows) {
  std::sort(rows.begin(), rows.end());
  std::lock_guard lock(mutex_);
  const int64_t size = std::visit([](const auto& model) { return model.size(); }, model_);
  for (size_t i = 0; i < rows.size(); ++i) {
    if (rows[i] < 0 || rows[i] >= size) {
      return absl::InvalidArgumentError(
          absl::StrFormat("rows: %d; the model has %d points", rows[i], size));
    }
    if (i > 0 && rows[i] == rows[i - 1]) {
      return absl::InvalidArgumentError(absl::StrFormat("rows: %d is there twice", rows[i]));
    }
  }
  posterior_ = nullptr;  // so that the factor need not be copied for it
  EGOSIEVE_RETURN_IF_ERROR(std::visit([&](auto& model) { return model.Remove(rows); }, model_));
  Changed();
  return absl::OkStatus();
}

absl::Status LearningModel::SetHyperparameters(const std::vector<double>& scales,
                                               double signal_stddev, double noise_stddev) {
  std::lock_guard lock(mutex_);
  gp::Hyperparameters hyperparameters =
      std::visit([](const auto& model) { return model.hyperparameters(); }, model_);
  if (scales.size() != hyperparameters.covariance.scales.size()) {
    return absl::InvalidArgumentError(absl::StrFormat("scale_count = %d; this model has %d scales",
                                                      scales.size(),
                                                      hyperparameters.covariance.scales.size()));
  }
  hyperparameters.covariance.scales = scales;
  hyperparameters.covariance.signal_stddev = signal_stddev;
  hyperparameters.noise_stddev = noise_stddev;
  EGOSIEVE_RETURN_IF_ERROR(
      std::visit([&](auto& model) { return model.SetHyperparameters(hyperparameters); }, model_));
  Changed();
  return absl::OkStatus();
}

absl::StatusOr<SearchResult> LearningModel::Optimize(const SearchOptions& options) {
  std::lock_guard lock(mutex_);
  const auto optimize = [&](auto& model) -> absl::StatusOr<SearchResult> {
    EGOSIEVE_ASSIGN_OR_RETURN(
        SearchResult result,
        SearchHyperparameters(*context_, model.hyperparameters(), model.observations(), options,
                              SparseOptionsOf(model)));
    EGOSIEVE_RETURN_IF_ERROR(model.SetHyperparameters(result.hyperparameters));
    return result;
  };
  EGOSIEVE_ASSIGN_OR_RETURN(SearchResult result, std::visit(optimize, model_));
  Changed();
  is_renewed_ = true;
  return result;
}

absl::StatusOr<SearchResult> LearningModel::Classify(const gp::LabelledInputs& data,
                                                     const SearchOptions* search) {
  std::lock_guard lock(mutex_);
  const auto* exact = std::get_if<gp::ExactModel>(&model_);
  if (exact == nullptr || exact->hyperparameters().mean != gp::MeanFunction::kZero) {
    return absl::FailedPreconditionError("classes need an exact model with the zero mean");
  }
  SearchResult result;
  result.hyperparameters = exact->hyperparameters();
  result.hyperparameters.noise_stddev = kLaplaceNoise;
  if (search != nullptr) {
    SearchOptions options = *search;
    options.of_classes = true;
    for (auto* bounds : {&options.lower, &options.upper}) {
      if (!bounds->empty()) bounds->back() = kLaplaceNoise;
    }
    EGOSIEVE_ASSIGN_OR_RETURN(
        result, SearchHyperparameters(*context_, result.hyperparameters,
                                      {data.inputs, data.labels, data.weights}, options));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(gp::LaplaceApproximation laplace,
                            gp::ApproximateByLaplace(*context_, result.hyperparameters.covariance,
                                                     data, gp::LikelihoodOrder::kValue));
  if (search == nullptr) {
    result.log_likelihood_at_start = result.log_likelihood = laplace.log_likelihood;
    result.points = data.inputs.rows;
    result.evaluations = 1;
    result.on_bound.resize(result.hyperparameters.count());
  }
  for (double& variance : laplace.noise_variances) {
    variance = std::max(0.0, variance - kLaplaceNoise * kLaplaceNoise);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(gp::ExactModel model,
                            gp::ExactModel::Create(context_, result.hyperparameters));
  EGOSIEVE_RETURN_IF_ERROR(
      model.AddObservations({data.inputs, laplace.targets, laplace.noise_variances}, 0));
  model_ = std::move(model);
  Changed();
  squash_ = gp::SquashParameters{};
  calibrated_ = is_laplace_ = true;
  return result;
}

absl::Status LearningModel::Calibrate() {
  std::lock_guard lock(mutex_);
  const auto fit = [&](const auto& model) -> absl::Status {
    if (model.size() < 2) {
      return absl::FailedPreconditionError(
          absl::StrFormat("calibration needs at least 2 points; there are %d", model.size()));
    }
    EGOSIEVE_RETURN_IF_ERROR(CheckLabels(model, is_laplace_));
    if (calibrated_) return absl::OkStatus();
    std::vector<double> labels;
    for (const double target : model.targets()) labels.push_back(0.5 * (target + 1.0));
    EGOSIEVE_ASSIGN_OR_RETURN(const gp::LeaveOneOut held_out, LeaveOneOutOf(model));
    EGOSIEVE_ASSIGN_OR_RETURN(
        const gp::SquashFit fit,
        gp::FitSquash(held_out.mean,
                      held_out.LatentVariance(model.hyperparameters().noise_variance()), labels,
                      gp::SquashParameters{}));
    squash_ = fit.parameters;
    calibrated_ = true;
    posterior_ = nullptr;
    return absl::OkStatus();
  };
  return std::visit(fit, model_);
}

void LearningModel::SetAnnotation(std::string annotation) {
  std::lock_guard lock(mutex_);
  annotation_ = std::move(annotation);
}

absl::StatusOr<gp::ModelFile> LearningModel::ToFile() {
  std::lock_guard lock(mutex_);
  gp::ModelFile file;
  const auto take = [&](auto& model) -> absl::Status {
    if (!is_renewed_) {
      EGOSIEVE_RETURN_IF_ERROR(Renew(model));
      posterior_ = nullptr;
      is_renewed_ = true;
    }
    file.model = model.State();
    file.sparse = SparseOptionsOf(model);
    return absl::OkStatus();
  };
  EGOSIEVE_RETURN_IF_ERROR(std::visit(take, model_));
  file.squash = squash_;
  file.is_laplace = is_laplace_;
  file.annotations = annotation_;
  return file;
}

LearningModel::Description LearningModel::Describe() const {
  std::lock_guard lock(mutex_);
  const auto describe = [&](const auto& model) {
    return Description{model.hyperparameters(),
                       squash_,
                       model.size(),
                       model.jitter(),
                       CheckLabels(model, is_laplace_).ok(),
                       model.outputs(),
                       SparseOptionsOf(model),
                       InducingSize(model)};
  };
  return std::visit(describe, model_);
}

std::string LearningModel::annotation() const {
  std::lock_guard lock(mutex_);
  return annotation_;
}

absl::StatusOr<DevicePosterior> LearningModel::Posterior() {
  std::lock_guard lock(mutex_);
  const auto make = [&](const auto& model) -> absl::StatusOr<DevicePosterior> {
    if (posterior_ == nullptr) {
      EGOSIEVE_ASSIGN_OR_RETURN(posterior_, PosteriorOf(model, squash_, options_, {}));
    }
    return DevicePosterior{context_, posterior_, CheckLabels(model, is_laplace_)};
  };
  return std::visit(make, model_);
}

absl::StatusOr<DevicePosterior> LearningModel::PosteriorOn(const kernels::Contexts& devices) const {
  std::lock_guard lock(mutex_);
  const auto make = [&](const auto& model) -> absl::StatusOr<DevicePosterior> {
    EGOSIEVE_ASSIGN_OR_RETURN(auto posterior, PosteriorOf(model, squash_, options_, devices));
    return DevicePosterior{devices.front(), std::move(posterior), CheckLabels(model, is_laplace_),
                           static_cast<int64_t>(devices.size())};
  };
  return std::visit(make, model_);
}

}  // namespace egosieve::embed
