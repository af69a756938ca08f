#include "vision/segmentation/learner_model.h"

#include <limits>
#include <utility>

#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

using gp::ExactModel;
using gp::SparseModel;

// This model decides when inducing inputs are chosen anew.
gp::SparseModelOptions NeverRefreshing(gp::SparseModelOptions options) {
  options.refresh_share = std::numeric_limits<double>::max();
  return options;
}

const gp::PointSet* SparsePoints(const std::variant<ExactModel, SparseModel>& model) {
  const auto* sparse = std::get_if<SparseModel>(&model);
  return sparse == nullptr ? nullptr : &sparse->points();
}

}  // namespace

absl::Status LearnerModelOptions::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(sparse.Validate());
  if (sparse.approximation == gp::SparseApproximation::kSubsetOfRegressors) {
    return absl::InvalidArgumentError(
        "the subset of regressors has no variance on devices; choose DTC, whose mean is the same");
  }
  return absl::OkStatus();
}

absl::StatusOr<LearnerModel> LearnerModel::Create(std::shared_ptr<kernels::Context> context,
                                                  const gp::Hyperparameters& hyperparameters,
                                                  const LearnerModelOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (context == nullptr) return absl::InvalidArgumentError("context is null");
  EGOSIEVE_RETURN_IF_ERROR(hyperparameters.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(Model model,
                            MakeModel(context, {hyperparameters, gp::PointSet()}, options));
  return LearnerModel(std::move(context), options, std::move(model));
}

LearnerModel::LearnerModel(std::shared_ptr<kernels::Context> context,
                           const LearnerModelOptions& options, Model model)
    : context_(std::move(context)), options_(options), model_(std::move(model)) {}

absl::StatusOr<LearnerModel::Model> LearnerModel::MakeModel(
    const std::shared_ptr<kernels::Context>& context, const gp::ExactModelState& state,
    const LearnerModelOptions& options) {
  if (options.kind == ModelKind::kSparse) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        SparseModel sparse, SparseModel::Restore(context, state, NeverRefreshing(options.sparse)));
    return Model(std::move(sparse));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(ExactModel exact, ExactModel::Restore(context, state));
  return Model(std::move(exact));
}

absl::Status LearnerModel::Add(kernels::ConstMatrixView<float> inputs,
                               absl::Span<const double> labels, int64_t frame) {
  if (inputs.rows == 0 && labels.empty()) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(
      std::visit([&](auto& model) { return model.Add(inputs, labels, frame); }, model_));
  changes_ += inputs.rows;
  if (auto* sparse = std::get_if<SparseModel>(&model_);
      sparse != nullptr &&
      static_cast<double>(changes_) > options_.sparse.refresh_share * sparse->size() &&
      sparse->Refresh().ok()) {  // the old inducing inputs serve on where new ones cannot be had
    changes_ = 0;
  }
  if (recording_) {
    ModelOperation operation;
    operation.kind = ModelOperation::Kind::kAdd;
    operation.frame = frame;
    for (int64_t i = 0; i < inputs.rows; ++i) {
      operation.inputs.insert(operation.inputs.end(), inputs.row(i), inputs.row(i) + inputs.cols);
    }
    operation.labels.assign(labels.begin(), labels.end());
    operations_.push_back(std::move(operation));
  }
  return absl::OkStatus();
}

absl::Status LearnerModel::Remove(absl::Span<const int64_t> rows) {
  if (rows.empty()) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(std::visit([&](auto& model) { return model.Remove(rows); }, model_));
  changes_ += static_cast<int64_t>(rows.size());
  if (recording_) {
    ModelOperation operation;
    operation.kind = ModelOperation::Kind::kRemove;
    operation.rows.assign(rows.begin(), rows.end());
    operations_.push_back(std::move(operation));
  }
  return absl::OkStatus();
}

absl::Status LearnerModel::SetHyperparameters(const gp::Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(
      std::visit([&](auto& model) { return model.SetHyperparameters(hyperparameters); }, model_));
  changes_ = 0;
  if (recording_) {
    ModelOperation operation;
    operation.kind = ModelOperation::Kind::kSetHyperparameters;
    operation.hyperparameters = hyperparameters;
    operations_.push_back(std::move(operation));
  }
  return absl::OkStatus();
}

absl::Status LearnerModel::Apply(const ModelOperation& operation) {
  switch (operation.kind) {
    case ModelOperation::Kind::kAdd:
      return Add(kernels::ConstMatrixView<float>(operation.inputs.data(),
                                                 static_cast<int64_t>(operation.labels.size()),
                                                 input_dimension()),
                 operation.labels, operation.frame);
    case ModelOperation::Kind::kRemove:
      return Remove(operation.rows);
    case ModelOperation::Kind::kSetHyperparameters:
      return SetHyperparameters(operation.hyperparameters);
  }
  return absl::OkStatus();
}

absl::Status LearnerModel::Rebuild() {
  if (auto* sparse = std::get_if<SparseModel>(&model_)) {
    EGOSIEVE_RETURN_IF_ERROR(sparse->Refresh());
    changes_ = 0;
    return absl::OkStatus();
  }
  return std::get<ExactModel>(model_).Refactorize();
}

gp::ExactModelState LearnerModel::State() const {
  return std::visit([](const auto& model) { return model.State(); }, model_);
}

absl::Status LearnerModel::Restore(const gp::ExactModelState& state) {
  EGOSIEVE_ASSIGN_OR_RETURN(model_, MakeModel(context_, state, options_));
  changes_ = 0;
  operations_.clear();
  return absl::OkStatus();
}

std::vector<ModelOperation> LearnerModel::TakeOperations() {
  return std::exchange(operations_, {});
}

int64_t LearnerModel::size() const {
  return std::visit([](const auto& model) { return model.size(); }, model_);
}

int64_t LearnerModel::inducing_size() const {
  const auto* sparse = std::get_if<SparseModel>(&model_);
  return sparse == nullptr ? size() : sparse->inducing_size();
}

const gp::Hyperparameters& LearnerModel::hyperparameters() const {
  return std::visit(
      [](const auto& model) -> const gp::Hyperparameters& { return model.hyperparameters(); },
      model_);
}

double LearnerModel::jitter() const {
  const auto* exact = std::get_if<ExactModel>(&model_);
  return exact == nullptr ? 0.0 : exact->jitter();
}

kernels::ConstMatrixView<double> LearnerModel::inputs() const {
  const gp::PointSet* points = SparsePoints(model_);
  return points == nullptr ? std::get<ExactModel>(model_).inputs()
                           : points->view(input_dimension());
}

absl::Span<const double> LearnerModel::targets() const {
  const gp::PointSet* points = SparsePoints(model_);
  return points == nullptr ? std::get<ExactModel>(model_).targets() : points->targets;
}

absl::Span<const int64_t> LearnerModel::birth_frames() const {
  const gp::PointSet* points = SparsePoints(model_);
  return points == nullptr ? std::get<ExactModel>(model_).birth_frames() : points->birth_frames;
}

absl::StatusOr<std::vector<float>> LearnerModel::PredictMean(
    kernels::ConstMatrixView<float> points) const {
  const auto* sparse = std::get_if<SparseModel>(&model_);
  if (sparse == nullptr) return std::get<ExactModel>(model_).PredictMean(points);
  const std::vector<double> wide = gp::Widen(points);
  EGOSIEVE_ASSIGN_OR_RETURN(
      const gp::Prediction prediction,
      sparse->Predict(kernels::ConstMatrixView<double>(wide.data(), points.rows, points.cols),
                      gp::PredictWhat::kMean));
  return std::vector<float>(prediction.mean.begin(), prediction.mean.end());
}

std::vector<double> LearnerModel::PredictOwnMean() const {
  return std::visit([](const auto& model) { return model.PredictOwnMean(); }, model_);
}

double LearnerModel::LogMarginalLikelihood() const {
  return std::visit([](const auto& model) { return model.LogMarginalLikelihood(); }, model_);
}

absl::StatusOr<gp::LeaveOneOut> LearnerModel::PredictLeaveOneOut(
    absl::Span<const int64_t> rows) const {
  const auto* sparse = std::get_if<SparseModel>(&model_);
  if (sparse == nullptr) return std::get<ExactModel>(model_).PredictLeaveOneOut(rows);
  EGOSIEVE_RETURN_IF_ERROR(gp::CheckRows(rows, size()));
  const gp::LeaveOneOut all = sparse->PredictLeaveOneOut();
  gp::LeaveOneOut chosen;
  for (const int64_t row : rows) {
    chosen.rows.push_back(row);
    chosen.mean.push_back(all.mean[row]);
    chosen.target_variance.push_back(all.target_variance[row]);
  }
  return chosen;
}

absl::StatusOr<std::shared_ptr<const gp::Posterior>> LearnerModel::MakePosterior(
    const gp::SquashParameters& squash) const {
  const auto* sparse = std::get_if<SparseModel>(&model_);
  if (sparse == nullptr) return std::get<ExactModel>(model_).MakePosterior(squash);
  absl::StatusOr<std::shared_ptr<const gp::Posterior>> posterior = sparse->MakePosterior(squash);
  if (posterior.ok()) return posterior;
  // Removals leave rounding in the sums: an inducing input whose data are gone may look as if it
  // had learnt less than nothing. Summed afresh, it has not.
  EGOSIEVE_ASSIGN_OR_RETURN(const SparseModel fresh,
                            SparseModel::Restore(context_, sparse->State(), sparse->options()));
  return fresh.MakePosterior(squash);
}

}  // namespace egosieve::vision
