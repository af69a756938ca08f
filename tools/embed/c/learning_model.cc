#include "tools/embed/c/learning_model.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_format.h"
#include "gp/calibration/leave_one_out.h"
#include "kernels/base/status_macros.h"

namespace egosieve::embed {
namespace {

// Labels are -1 and 1, or between. Values that are all 0 or 1 fit that, too, but are labels of
// another convention nearly always, and their probabilities would be wrong.
absl::Status CheckLabels(const gp::ExactModel& model) {
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

}  // namespace

LearningModel::LearningModel(gp::ExactModel model, const kernels::DensePosteriorOptions& options)
    : context_(model.context()),
      dimension_(model.input_dimension()),
      options_(options),
      model_(std::move(model)) {}

absl::StatusOr<std::shared_ptr<LearningModel>> LearningModel::Create(
    std::shared_ptr<kernels::Context> context, const gp::Hyperparameters& hyperparameters,
    const kernels::DensePosteriorOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(gp::ExactModel model,
                            gp::ExactModel::Create(std::move(context), hyperparameters));
  return std::shared_ptr<LearningModel>(new LearningModel(std::move(model), options));
}

absl::StatusOr<std::shared_ptr<LearningModel>> LearningModel::FromFile(
    std::shared_ptr<kernels::Context> context, gp::ModelFile file) {
  EGOSIEVE_ASSIGN_OR_RETURN(gp::ExactModel exact,
                            gp::ExactModel::Restore(std::move(context), file.model));
  std::shared_ptr<LearningModel> model(new LearningModel(std::move(exact), {}));
  model->squash_ = file.squash;
  model->annotation_ = std::move(file.annotations);
  return model;
}

void LearningModel::Changed() {
  posterior_ = nullptr;
  calibrated_ = false;
}

absl::Status LearningModel::Condition(const gp::Observations& added) {
  std::lock_guard lock(mutex_);
  EGOSIEVE_RETURN_IF_ERROR(model_.AddObservations(added, 0));
  Changed();
  return absl::OkStatus();
}

absl::Status LearningModel::Remove(std::vector<int64_t> rows) {
  std::sort(rows.begin(), rows.end());
  std::lock_guard lock(mutex_);
  for (size_t i = 0; i < rows.size(); ++i) {
    if (rows[i] < 0 || rows[i] >= model_.size()) {
      return absl::InvalidArgumentError(
          absl::StrFormat("rows: %d; the model has %d points", rows[i], model_.size()));
    }
    if (i > 0 && rows[i] == rows[i - 1]) {
      return absl::InvalidArgumentError(absl::StrFormat("rows: %d stands there twice", rows[i]));
    }
  }
  EGOSIEVE_RETURN_IF_ERROR(model_.Remove(rows));
  Changed();
  return absl::OkStatus();
}

absl::Status LearningModel::SetHyperparameters(const std::vector<double>& scales,
                                               double signal_stddev, double noise_stddev) {
  std::lock_guard lock(mutex_);
  gp::Hyperparameters hyperparameters = model_.hyperparameters();
  if (scales.size() != hyperparameters.covariance.scales.size()) {
    return absl::InvalidArgumentError(absl::StrFormat("scale_count = %d; this model has %d scales",
                                                      scales.size(),
                                                      hyperparameters.covariance.scales.size()));
  }
  hyperparameters.covariance.scales = scales;
  hyperparameters.covariance.signal_stddev = signal_stddev;
  hyperparameters.noise_stddev = noise_stddev;
  EGOSIEVE_RETURN_IF_ERROR(model_.SetHyperparameters(hyperparameters));
  Changed();
  return absl::OkStatus();
}

absl::StatusOr<SearchResult> LearningModel::Optimize(const SearchOptions& options) {
  std::lock_guard lock(mutex_);
  EGOSIEVE_ASSIGN_OR_RETURN(
      SearchResult result,
      SearchHyperparameters(*context_, model_.hyperparameters(), model_.observations(), options));
  EGOSIEVE_RETURN_IF_ERROR(model_.SetHyperparameters(result.hyperparameters));
  Changed();
  return result;
}

absl::Status LearningModel::Calibrate() {
  std::lock_guard lock(mutex_);
  if (model_.size() < 2) {
    return absl::FailedPreconditionError(
        absl::StrFormat("calibration needs at least 2 points; there are %d", model_.size()));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckLabels(model_));
  if (calibrated_) return absl::OkStatus();
  std::vector<double> labels;
  for (const double target : model_.targets()) labels.push_back(0.5 * (target + 1.0));
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::LeaveOneOut held_out, model_.PredictLeaveOneOut());
  EGOSIEVE_ASSIGN_OR_RETURN(
      const gp::SquashFit fit,
      gp::FitSquash(held_out.mean,
                    held_out.LatentVariance(model_.hyperparameters().noise_variance()), labels,
                    gp::SquashParameters{}));
  squash_ = fit.parameters;
  calibrated_ = true;
  posterior_ = nullptr;
  return absl::OkStatus();
}

void LearningModel::SetAnnotation(std::string annotation) {
  std::lock_guard lock(mutex_);
  annotation_ = std::move(annotation);
}

absl::StatusOr<gp::ModelFile> LearningModel::ToFile() {
  std::lock_guard lock(mutex_);
  EGOSIEVE_RETURN_IF_ERROR(model_.Refactorize());
  Changed();
  gp::ModelFile file;
  file.model = model_.State();
  file.squash = squash_;
  file.annotations = annotation_;
  return file;
}

LearningModel::Description LearningModel::Describe() const {
  std::lock_guard lock(mutex_);
  return {model_.hyperparameters(), squash_,         model_.size(), model_.jitter(),
          CheckLabels(model_).ok(), model_.outputs()};
}

std::string LearningModel::annotation() const {
  std::lock_guard lock(mutex_);
  return annotation_;
}

absl::StatusOr<DevicePosterior> LearningModel::Posterior() {
  std::lock_guard lock(mutex_);
  if (posterior_ == nullptr) {
    EGOSIEVE_ASSIGN_OR_RETURN(posterior_, model_.MakePosterior(squash_, options_));
  }
  return DevicePosterior{context_, posterior_, CheckLabels(model_)};
}

}  // namespace egosieve::embed
