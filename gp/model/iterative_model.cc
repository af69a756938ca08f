#include "gp/model/iterative_model.h"

#include <algorithm>
#include <utility>

#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/tile_operations.h"
#include "gp/model/inducing_points.h"
#include "gp/model/sparse_solution.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr int64_t kColumnGroup = 64;  // of V on a thread at a time

// out: columns x rows.
std::vector<double> TransposeOf(const std::vector<double>& from, int64_t rows, int64_t columns) {
  std::vector<double> out(from.size());
  for (int64_t i = 0; i < rows; ++i) {
    for (int64_t c = 0; c < columns; ++c) out[c * rows + i] = from[i * columns + c];
  }
  return out;
}

// M^-1 of (IM4).
class LowRankInverse {
 public:
  static absl::StatusOr<LowRankInverse> Create(kernels::Context& context,
                                               const Hyperparameters& hyperparameters,
                                               const PointSet& points, int64_t rank) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        std::vector<double> inputs,
        ChooseInducingInputs(context, hyperparameters.covariance,
                             points.view(hyperparameters.covariance.input_dimension()), rank));
    LowRankInverse inverse;  // what follows from the targets is not used
    EGOSIEVE_ASSIGN_OR_RETURN(inverse.solution_,
                              SolveSparse(context, {}, hyperparameters, points, std::move(inputs),
                                          &inverse.projections_));
    return inverse;
  }

  void Apply(ConstMatrixView<double> r, MatrixView<double> out) const {
    const int64_t n = r.cols, k = r.rows, m = projections_.cols();
    const std::vector<double>& noise = solution_.lambda;
    for (int64_t c = 0; c < k; ++c) {
      for (int64_t i = 0; i < n; ++i) out(c, i) = r(c, i) / noise[i];
    }
    std::vector<double> sums(k * m), solved(m * k);  // V^T D^-1 r, A^-1 of it
    kernels::ParallelFor((m + kColumnGroup - 1) / kColumnGroup, 2.0 * n * k * m, [&](int64_t g) {
      const int64_t first = g * kColumnGroup, last = std::min(m, first + kColumnGroup);
      for (int64_t i = 0; i < n; ++i) {
        const double* v = projections_.row(i);
        for (int64_t c = 0; c < k; ++c) {
          const double w = out(c, i);
          for (int64_t j = first; j < last; ++j) sums[c * m + j] += w * v[j];
        }
      }
    });
    for (int64_t c = 0; c < k; ++c) {
      std::vector<double> column(&sums[c * m], &sums[c * m] + m);
      SolveSum(solution_.sum_factor, column);
      std::copy(column.begin(), column.end(), &solved[c * m]);
    }
    kernels::ParallelFor((n + kRowTile - 1) / kRowTile, 2.0 * n * k * m, [&](int64_t t) {
      const int64_t end = std::min(n, (t + 1) * kRowTile);
      for (int64_t i = t * kRowTile; i < end; ++i) {
        for (int64_t c = 0; c < k; ++c) {
          out(c, i) -= Dot(projections_.row(i), &solved[c * m], m) / noise[i];
        }
      }
    });
  }

 private:
  SparseSolution solution_;
  AlignedMatrix projections_;  // V, n x m
};

constexpr int64_t kProductGroup = 128;  // rows of a tile on a thread at a time

// Adds the parts of (KP1) that belong to a tile whose first element is (row, column): its own, and
// below the diagonal those of its transpose. partial: room for k x columns of each group of rows.
void AddTile(ConstMatrixView<double> tile, int64_t row, int64_t column, ConstMatrixView<double> v,
             std::vector<double>& partial, MatrixView<double> out) {
  const int64_t k = v.rows, groups = (tile.rows + kProductGroup - 1) / kProductGroup;
  const bool both = row != column;
  const int64_t room = k * tile.cols;
  partial.assign(both ? groups * room : 0, 0.0);
  kernels::ParallelFor(groups, 4.0 * k * tile.rows * tile.cols, [&](int64_t g) {
    const int64_t end = std::min(tile.rows, (g + 1) * kProductGroup);
    for (int64_t i = g * kProductGroup; i < end; ++i) {
      const double* values = tile.row(i);
      for (int64_t c = 0; c < k; ++c) {
        out(c, row + i) += LaneDot(values, v.row(c) + column, tile.cols);
        if (!both) continue;
        double* target = partial.data() + g * room + c * tile.cols;
        const double weight = v(c, row + i);
        for (int64_t j = 0; j < tile.cols; ++j) target[j] += weight * values[j];
      }
    }
  });
  for (int64_t g = 0; both && g < groups; ++g) {
    for (int64_t c = 0; c < k; ++c) {
      const double* from = partial.data() + g * room + c * tile.cols;
      for (int64_t j = 0; j < tile.cols; ++j) out(c, column + j) += from[j];
    }
  }
}

}  // namespace

absl::Status MultiplyCovariance(kernels::Context& context,
                                const kernels::CovarianceParameters& covariance,
                                ConstMatrixView<double> x, absl::Span<const double> diagonal,
                                ConstMatrixView<double> v, MatrixView<double> out) {
  const int64_t n = x.rows;
  for (int64_t c = 0; c < v.rows; ++c) {
    for (int64_t i = 0; i < n; ++i) out(c, i) = diagonal[i] * v(c, i);
  }
  const int64_t side = std::min(kProductTile, n);
  AlignedMatrix room(side, side);
  std::vector<double> partial;
  for (int64_t row = 0; row < n; row += kProductTile) {
    const int64_t row_end = std::min(row + kProductTile, n);
    for (int64_t column = 0; column <= row; column += kProductTile) {
      const int64_t column_end = std::min(column + kProductTile, n);
      const MatrixView<double> tile = room.block(row_end - row, column_end - column);
      EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance(context, covariance,
                                                        x.rows_between(row, row_end),
                                                        x.rows_between(column, column_end), tile));
      AddTile(tile, row, column, v, partial, out);
    }
  }
  return absl::OkStatus();
}

absl::Status IterativeModelOptions::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(kernels::CheckOptions({{"rank", rank, rank >= 1, "be positive"}}));
  return gradients.Validate();
}

absl::StatusOr<IterativeModel> IterativeModel::Create(std::shared_ptr<kernels::Context> context,
                                                      const Hyperparameters& hyperparameters,
                                                      const IterativeModelOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(CheckSetUp(context.get(), hyperparameters));
  EGOSIEVE_RETURN_IF_ERROR(CheckZeroMean("iterative", hyperparameters));
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  IterativeModel model(std::move(context), hyperparameters);
  model.options_ = options;
  return model;
}

absl::StatusOr<IterativeModel> IterativeModel::Restore(std::shared_ptr<kernels::Context> context,
                                                       const ExactModelState& state,
                                                       const IterativeModelOptions& options,
                                                       std::vector<double> alpha) {
  EGOSIEVE_RETURN_IF_ERROR(state.Validate());
  EGOSIEVE_REQUIRE(InvalidArgument, alpha.empty() || alpha.size() == state.points.targets.size(),
                   "%d weights; there are %d targets", alpha.size(), state.points.targets.size());
  EGOSIEVE_ASSIGN_OR_RETURN(IterativeModel model,
                            Create(std::move(context), state.hyperparameters, options));
  model.points_ = state.points;
  model.start_ = std::move(alpha);
  return model;
}

absl::Status IterativeModel::AddObservations(const Observations& added, int64_t time) {
  EGOSIEVE_RETURN_IF_ERROR(CheckAddition(added, points_, input_dimension()));
  if (added.size() == 0) return absl::OkStatus();
  PointSet points = points_;
  points.Append(added, time);
  points_ = std::move(points);
  Forget();
  return absl::OkStatus();
}

absl::Status IterativeModel::Remove(absl::Span<const int64_t> rows) {
  EGOSIEVE_RETURN_IF_ERROR(CheckRows(rows, size()));
  if (rows.empty()) return absl::OkStatus();
  points_.Remove(rows);
  Forget();
  return absl::OkStatus();
}

absl::Status IterativeModel::SetHyperparameters(const Hyperparameters& hyperparameters) {
  EGOSIEVE_RETURN_IF_ERROR(CheckReplacement(hyperparameters, size(), input_dimension()));
  EGOSIEVE_RETURN_IF_ERROR(CheckZeroMean("iterative", hyperparameters));
  hyperparameters_ = hyperparameters;
  Forget();
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const IterativeModel::Solution>> IterativeModel::Solve() const {
  if (solution_ != nullptr) return solution_;
  const int64_t n = size(), k = outputs();
  std::vector<double> diagonal(n, hyperparameters_.noise_variance());
  for (int64_t i = 0; i < n; ++i) diagonal[i] += points_.noise_variance(i);
  const auto multiply = [&](ConstMatrixView<double> v, MatrixView<double> out) {
    return MultiplyCovariance(*context_, hyperparameters_.covariance,
                              points_.view(input_dimension()), diagonal, v, out);
  };
  std::optional<LowRankInverse> inverse;  // made where weights to start from are not enough
  const auto precondition = [&](ConstMatrixView<double> r, MatrixView<double> out) {
    if (!inverse.has_value()) {
      EGOSIEVE_ASSIGN_OR_RETURN(
          inverse, LowRankInverse::Create(*context_, hyperparameters_, points_, options_.rank));
    }
    inverse->Apply(r, out);
    return absl::OkStatus();
  };
  const std::vector<double> b = TransposeOf(points_.targets, n, k);
  std::vector<double> x = start_.empty() ? std::vector<double>(n * k) : TransposeOf(start_, n, k);
  auto solution = std::make_shared<Solution>();
  EGOSIEVE_ASSIGN_OR_RETURN(
      solution->report,
      SolveByConjugateGradients(multiply, precondition, options_.gradients, {b.data(), k, n},
                                MatrixView<double>(x.data(), k, n)));
  solution->weights.points = n;
  solution->weights.outputs = k;
  solution->weights.alpha = TransposeOf(x, k, n);
  solution_ = std::move(solution);
  return solution_;
}

std::optional<ConjugateGradientReport> IterativeModel::report() const {
  if (solution_ == nullptr) return std::nullopt;
  return solution_->report;
}

absl::StatusOr<RegressionModel::PosteriorParts> IterativeModel::Parts() const {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const Solution> solution, Solve());
  return PosteriorParts{inputs(),
                        &solution->weights,
                        {kernels::FactorKind::kNone, {nullptr, size(), size()}, solution}};
}

}  // namespace egosieve::gp
