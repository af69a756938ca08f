#include "vision/segmentation/learner_model.h"

#include <limits>
#include <utility>

#include "gp/model/regression_model.h"
#include "kernels/base/status_macros.h"

namespace egosieve::vision {
namespace {

using gp::ExactModel;

const gp::PointSet* SparsePoints(const std::variant<ExactModel, DeferredSparseModel>& model) {
  const auto* sparse = std::get_if<DeferredSparseModel>(&model);
  return sparse == nullptr ? nullptr : &sparse->State().points;
}

}  // namespace

absl::StatusOr<DeferredSparseModel> DeferredSparseModel::Restore(
    std::shared_ptr<kernels::Context> context, gp::ExactModelState state,
    const gp::SparseModelOptions& options) {
  DeferredSparseModel model;
  // Solved at once, so that an invalid state is refused here.
  EGOSIEVE_ASSIGN_OR_RETURN(model.solved_, gp::SparseModel::Restore(context, state, options));
  model.context_ = std::move(context);
  model.options_ = options;
  model.state_ = std::move(state);
  return model;
}

absl::Status DeferredSparseModel::AddObservations(const gp::Observations& added, int64_t frame) {
  EGOSIEVE_RETURN_IF_ERROR(gp::CheckAddition(added, state_.points, input_dimension()));
  gp::PointSet points = state_.points;
  points.Append(added, frame);
  state_.points = std::move(points);
  solved_.reset();
  return absl::OkStatus();
}

absl::Status DeferredSparseModel::Remove(absl::Span<const int64_t> rows) {
  EGOSIEVE_RETURN_IF_ERROR(gp::CheckRows(rows, size()));
  state_.points.Remove(rows);
  solved_.reset();
  return absl::OkStatus();
}

absl::Status DeferredSparseModel::SetTargets(kernels::ConstMatrixView<double> targets) {
  EGOSIEVE_RETURN_IF_ERROR(gp::ReplaceTargets(targets, input_dimension(), state_.points));
  solved_.reset();
  return absl::OkStatus();
}

absl::Status DeferredSparseModel::SetHyperparameters(const gp::Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(gp::CheckReplacement(hyperparameters, size(), input_dimension()));
  state_.hyperparameters = hyperparameters;
  solved_.reset();
  return absl::OkStatus();
}

absl::StatusOr<const gp::SparseModel*> DeferredSparseModel::Solved() const {
  if (!solved_.has_value()) {
    EGOSIEVE_ASSIGN_OR_RETURN(solved_, gp::SparseModel::Restore(context_, state_, options_));
  }
  return &*solved_;
}

absl::Status LearnerModelOptions::Validate() const { return sparse.Validate(); }

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
    EGOSIEVE_ASSIGN_OR_RETURN(DeferredSparseModel sparse,
                              DeferredSparseModel::Restore(context, state, options.sparse));
    return Model(std::move(sparse));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(ExactModel exact, ExactModel::Restore(context, state));
  return Model(std::move(exact));
}

absl::Status LearnerModel::Add(kernels::ConstMatrixView<float> inputs,
                               absl::Span<const double> labels, int64_t frame) {
  if (inputs.rows == 0 && labels.empty()) return absl::OkStatus();
  const std::vector<double> wide = gp::Widen(inputs);
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> targets, gp::TargetsOfLabels(labels));
  const gp::Observations added({wide.data(), inputs.rows, inputs.cols}, targets);
  return std::visit([&](auto& model) { return model.AddObservations(added, frame); }, model_);
}

absl::Status LearnerModel::Remove(absl::Span<const int64_t> rows) {
  if (rows.empty()) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(std::visit([&](auto& model) { return model.Remove(rows); }, model_));
  return absl::OkStatus();
}

absl::Status LearnerModel::SetLabels(absl::Span<const double> labels) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> targets, gp::TargetsOfLabels(labels));
  const kernels::ConstMatrixView<double> view(targets.data(), static_cast<int64_t>(targets.size()),
                                              1);
  EGOSIEVE_RETURN_IF_ERROR(std::visit([&](auto& model) { return model.SetTargets(view); }, model_));
  return absl::OkStatus();
}

absl::Status LearnerModel::SetHyperparameters(const gp::Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(
      std::visit([&](auto& model) { return model.SetHyperparameters(hyperparameters); }, model_));
  return absl::OkStatus();
}

absl::Status LearnerModel::Rebuild() {
  auto* exact = std::get_if<ExactModel>(&model_);
  return exact == nullptr ? absl::OkStatus() : exact->Refactorize();
}

gp::ExactModelState LearnerModel::State() const {
  return std::visit([](const auto& model) { return model.State(); }, model_);
}

absl::Status LearnerModel::Restore(const gp::ExactModelState& state) {
  EGOSIEVE_ASSIGN_OR_RETURN(model_, MakeModel(context_, state, options_));
  return absl::OkStatus();
}

int64_t LearnerModel::size() const {
  return std::visit([](const auto& model) { return model.size(); }, model_);
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
  return points == nullptr ? std::get<ExactModel>(model_).insertion_times()
                           : points->insertion_times;
}

absl::StatusOr<std::vector<float>> LearnerModel::PredictMean(
    kernels::ConstMatrixView<float> points) const {
  if (const auto* exact = std::get_if<ExactModel>(&model_)) return exact->PredictMean(points);
  const std::vector<double> wide = gp::Widen(points);
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::SparseModel* sparse,
                            std::get<DeferredSparseModel>(model_).Solved());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> mean,
                            sparse->PredictMean({wide.data(), points.rows, points.cols}));
  return std::vector<float>(mean.begin(), mean.end());
}

absl::StatusOr<std::vector<double>> LearnerModel::PredictOwnMean() const {
  if (const auto* exact = std::get_if<ExactModel>(&model_)) return exact->PredictOwnMean();
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::SparseModel* sparse,
                            std::get<DeferredSparseModel>(model_).Solved());
  return sparse->PredictOwnMean();
}

double LearnerModel::LogMarginalLikelihood() const {
  if (const auto* exact = std::get_if<ExactModel>(&model_)) return exact->LogMarginalLikelihood();
  const absl::StatusOr<const gp::SparseModel*> sparse =
      std::get<DeferredSparseModel>(model_).Solved();
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  return sparse.ok() ? (*sparse)->LogMarginalLikelihood() : kNone;
}

absl::StatusOr<gp::LeaveOneOut> LearnerModel::PredictLeaveOneOut(
    absl::Span<const int64_t> rows) const {
  if (const auto* exact = std::get_if<ExactModel>(&model_)) return exact->PredictLeaveOneOut(rows);
  EGOSIEVE_RETURN_IF_ERROR(gp::CheckRows(rows, size()));
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::SparseModel* sparse,
                            std::get<DeferredSparseModel>(model_).Solved());
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::LeaveOneOut all, sparse->PredictLeaveOneOut());
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
  if (const auto* exact = std::get_if<ExactModel>(&model_)) return exact->MakePosterior(squash);
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::SparseModel* sparse,
                            std::get<DeferredSparseModel>(model_).Solved());
  return sparse->MakePosterior(squash);
}

}  // namespace egosieve::vision
