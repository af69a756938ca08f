#include "gp/model/sparse_model.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_format.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/model/model_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;

absl::Status CheckOneOutput(int64_t outputs) {
  if (outputs == 1) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "targets of %d outputs; a sparse model has one: make a model for each", outputs));
}

absl::Status CheckZeroMean(const Hyperparameters& hyperparameters) {
  if (hyperparameters.mean == MeanFunction::kZero) return absl::OkStatus();
  return absl::UnimplementedError(
      "sparse models have the zero mean; take the mean off the targets");
}

}  // namespace

absl::StatusOr<SparseModel> SparseModel::Create(std::shared_ptr<kernels::Context> context,
                                                const Hyperparameters& hyperparameters,
                                                const SparseModelOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(CheckSetUp(context.get(), hyperparameters));
  EGOSIEVE_RETURN_IF_ERROR(CheckZeroMean(hyperparameters));
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  SparseModel model;
  model.context_ = std::move(context);
  model.hyperparameters_ = hyperparameters;
  model.options_ = options;
  return model;
}

absl::StatusOr<SparseModel> SparseModel::Restore(std::shared_ptr<kernels::Context> context,
                                                 const ExactModelState& state,
                                                 const SparseModelOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(state.Validate());
  EGOSIEVE_RETURN_IF_ERROR(CheckOneOutput(state.points.outputs));
  EGOSIEVE_ASSIGN_OR_RETURN(SparseModel model,
                            Create(std::move(context), state.hyperparameters, options));
  model.points_ = state.points;
  EGOSIEVE_RETURN_IF_ERROR(model.Refresh());
  return model;
}

absl::Status SparseModel::Add(ConstMatrixView<float> inputs, absl::Span<const double> labels,
                              int64_t time) {
  const std::vector<double> wide = Widen(inputs);
  return Add(ConstMatrixView<double>(wide.data(), inputs.rows, inputs.cols), labels, time);
}

absl::Status SparseModel::Add(ConstMatrixView<double> inputs, absl::Span<const double> labels,
                              int64_t time) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> targets, TargetsOfLabels(labels));
  return AddTargets(inputs, targets, time);
}

absl::Status SparseModel::AddObservations(const Observations& added, int64_t time) {
  EGOSIEVE_RETURN_IF_ERROR(CheckAddition(added, points_, input_dimension()));
  if (added.size() == 0) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(CheckOneOutput(added.outputs()));
  PointSet points = points_;
  points.Append(added, time);
  const int64_t k = added.size(), m = inducing_size();
  if (m == 0) {
    EGOSIEVE_ASSIGN_OR_RETURN(solution_,
                              ChooseAndSolveSparse(*context_, options_, hyperparameters_, points));
    points_ = std::move(points);
    changes_ = 0;
    return absl::OkStatus();
  }
  if (RefreshIfStale(k, points)) return absl::OkStatus();
  AlignedMatrix v(k, m);
  std::vector<double> lambda;
  EGOSIEVE_RETURN_IF_ERROR(ProjectPoints(*context_, options_, hyperparameters_, solution_,
                                         added.inputs, added.noise_variances, v, lambda));
  AlignedMatrix sum = CopyOfSum(solution_.sum);
  AddTerms(v.view(), lambda.data(), 1.0, sum.view());
  EGOSIEVE_ASSIGN_OR_RETURN(AlignedMatrix sum_factor, FactorOfSum(sum));
  std::vector<double> weights(m, 0.0);
  AddTargetTerms(solution_.projections.data(), solution_.lambda.data(), points.targets.data(),
                 size(), weights);
  for (int64_t i = 0; i < k; ++i) {
    AddTargetTerms(v.row(i), &lambda[i], &added.targets(i, 0), 1, weights);
  }
  SolveSum(sum_factor, weights);
  solution_.projections.reserve(solution_.projections.size() + k * m);
  solution_.lambda.reserve(solution_.lambda.size() + k);
  // Nothing below can fail.
  for (int64_t i = 0; i < k; ++i) {
    solution_.projections.insert(solution_.projections.end(), v.row(i), v.row(i) + m);
  }
  solution_.lambda.insert(solution_.lambda.end(), lambda.begin(), lambda.end());
  Commit(std::move(sum), std::move(sum_factor), std::move(weights), std::move(points), k);
  return absl::OkStatus();
}

absl::Status SparseModel::Remove(absl::Span<const int64_t> rows) {
  EGOSIEVE_RETURN_IF_ERROR(CheckRows(rows, size()));
  if (rows.empty()) return absl::OkStatus();
  PointSet points = points_;
  points.Remove(rows);
  const int64_t k = static_cast<int64_t>(rows.size()), m = inducing_size();
  if (RefreshIfStale(k, points)) return absl::OkStatus();
  AlignedMatrix v(k, m);
  std::vector<double> lambda;
  std::vector<double> weights(m, 0.0);
  int64_t kept = 0;  // the first row of a range of kept rows
  const auto add_stretch = [&](int64_t end) {
    AddTargetTerms(solution_.projections.data() + kept * m, solution_.lambda.data() + kept,
                   points_.targets.data() + kept, end - kept, weights);
    kept = end + 1;
  };
  for (int64_t i = 0; i < k; ++i) {
    std::copy_n(solution_.projections.begin() + rows[i] * m, m, v.row(i));
    lambda.push_back(solution_.lambda[rows[i]]);
    add_stretch(rows[i]);
  }
  add_stretch(size());
  AlignedMatrix sum = CopyOfSum(solution_.sum);
  AddTerms(v.view(), lambda.data(), -1.0, sum.view());
  EGOSIEVE_ASSIGN_OR_RETURN(AlignedMatrix sum_factor, FactorOfSum(sum));
  SolveSum(sum_factor, weights);
  // Nothing below can fail.
  EraseRows(m, rows, solution_.projections);
  EraseRows(1, rows, solution_.lambda);
  Commit(std::move(sum), std::move(sum_factor), std::move(weights), std::move(points), k);
  return absl::OkStatus();
}

void SparseModel::Commit(AlignedMatrix sum, AlignedMatrix sum_factor, std::vector<double> weights,
                         PointSet points, int64_t changed) {
  solution_.sum = std::move(sum);
  solution_.sum_factor = std::move(sum_factor);
  solution_.weights = std::move(weights);
  solution_.posterior_form.reset();
  points_ = std::move(points);
  changes_ += changed;
}

bool SparseModel::RefreshIfStale(int64_t changed, PointSet& points) {
  const double limit = options_.refresh_share * static_cast<double>(points.size());
  if (!(static_cast<double>(changes_ + changed) > limit)) return false;
  absl::StatusOr<SparseSolution> solution =
      ChooseAndSolveSparse(*context_, options_, hyperparameters_, points);
  // If new inducing inputs cannot be computed, the old ones stay in use.
  if (!solution.ok()) return false;
  solution_ = *std::move(solution);
  points_ = std::move(points);
  changes_ = 0;
  return true;
}

absl::Status SparseModel::SetHyperparameters(const Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(CheckReplacement(hyperparameters, size(), input_dimension()));
  EGOSIEVE_RETURN_IF_ERROR(CheckZeroMean(hyperparameters));
  Hyperparameters copy = hyperparameters;
  EGOSIEVE_ASSIGN_OR_RETURN(solution_,
                            ChooseAndSolveSparse(*context_, options_, hyperparameters, points_));
  hyperparameters_ = std::move(copy);
  changes_ = 0;
  return absl::OkStatus();
}

absl::Status SparseModel::Refresh() {
  EGOSIEVE_ASSIGN_OR_RETURN(solution_,
                            ChooseAndSolveSparse(*context_, options_, hyperparameters_, points_));
  changes_ = 0;
  return absl::OkStatus();
}

absl::Status SparseModel::SetInducingInputs(ConstMatrixView<double> inputs) {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(inputs, input_dimension()));
  std::vector<double> copy;
  for (int64_t i = 0; i < inputs.rows; ++i) {
    copy.insert(copy.end(), inputs.row(i), inputs.row(i) + inputs.cols);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(
      solution_, SolveSparse(*context_, options_, hyperparameters_, points_, std::move(copy)));
  return absl::OkStatus();
}

}  // namespace egosieve::gp
