#include "gp/model/inducing_points.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gp/covariance/hyperparameters.h"
#include "gp/linalg/aligned_matrix.h"
#include "gp/model/point_set.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/covariance_matrix.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;
using kernels::MatrixView;

constexpr double kRelativeTolerance = 1e-8;
constexpr int64_t kRowsPerTask = 512;
// Up to this number of points their whole matrix is computed at once, 32 MiB at most: one operation
// on the device instead of one per column, each of which would wait for other work there.
constexpr int64_t kWholeMatrixPoints = 2048;

// (1).
absl::StatusOr<std::vector<int64_t>> PivotedRows(kernels::Context& context,
                                                 const kernels::CovarianceParameters& covariance,
                                                 ConstMatrixView<double> x, int64_t count) {
  const int64_t n = x.rows;
  AlignedMatrix l(n, count);
  const bool whole = n <= kWholeMatrixPoints;
  AlignedMatrix covariances(whole ? n : 0, whole ? n : 0);
  if (whole) {
    EGOSIEVE_RETURN_IF_ERROR(kernels::CovarianceMatrix(
        context, covariance, x, 0.0, kernels::Triangle::kFull, covariances.view()));
  }
  std::vector<double> residual(n), of_pivot(whole ? 0 : n);
  for (int64_t i = 0; i < n; ++i) residual[i] = PriorVariance(covariance, x.row(i));
  std::vector<int64_t> rows;
  double first = 0.0;
  while (static_cast<int64_t>(rows.size()) < count) {
    const int64_t step = static_cast<int64_t>(rows.size());
    const int64_t pivot = std::max_element(residual.begin(), residual.end()) - residual.begin();
    if (step == 0) first = residual[pivot];
    if (!(residual[pivot] > kRelativeTolerance * first)) break;
    if (!whole) {
      EGOSIEVE_RETURN_IF_ERROR(kernels::CrossCovariance(context, covariance, x,
                                                        x.rows_between(pivot, pivot + 1),
                                                        MatrixView<double>(of_pivot.data(), n, 1)));
    }
    const double* column = whole ? covariances.row(pivot) : of_pivot.data();
    const double root = std::sqrt(residual[pivot]);
    const double* pivot_row = l.row(pivot);
    kernels::ParallelFor((n + kRowsPerTask - 1) / kRowsPerTask, 2.0 * n * step, [&](int64_t task) {
      const int64_t end = std::min(n, (task + 1) * kRowsPerTask);
      for (int64_t i = task * kRowsPerTask; i < end; ++i) {
        double* row = l.row(i);
        double lanes[8] = {};
        int64_t p = 0;
        for (; p + 8 <= step; p += 8) {
          for (int lane = 0; lane < 8; ++lane) lanes[lane] += row[p + lane] * pivot_row[p + lane];
        }
        double sum = column[i] - std::accumulate(lanes, lanes + 8, 0.0);
        for (; p < step; ++p) sum -= row[p] * pivot_row[p];
        if (i != pivot) row[step] = sum / root;
      }
    });
    l.row(pivot)[step] = root;
    for (int64_t i = 0; i < n; ++i) residual[i] -= l.row(i)[step] * l.row(i)[step];
    residual[pivot] = 0.0;
    rows.push_back(pivot);
  }
  return rows;
}

}  // namespace

absl::StatusOr<std::vector<double>> ChooseInducingInputs(
    kernels::Context& context, const kernels::CovarianceParameters& covariance,
    ConstMatrixView<double> x, int64_t count) {
  EGOSIEVE_REQUIRE(InvalidArgument, count >= 1, "the number of inducing points must be positive");
  if (x.rows <= count) return Widen(x);
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> rows,
                            PivotedRows(context, covariance, x, count));
  std::vector<double> inputs;
  inputs.reserve(rows.size() * x.cols);
  for (const int64_t row : rows) inputs.insert(inputs.end(), x.row(row), x.row(row) + x.cols);
  return inputs;
}

}  // namespace egosieve::gp
