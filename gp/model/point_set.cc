#include "gp/model/point_set.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;

constexpr int64_t kLargestIdentity = int64_t{1} << 62;

absl::Status CheckTargets(ConstMatrixView<double> targets, int64_t count) {
  EGOSIEVE_REQUIRE(InvalidArgument, targets.rows == count && targets.cols >= 1,
                   "%d inputs and %d x %d labels or targets", count, targets.rows, targets.cols);
  return kernels::CheckFinite("targets", targets);
}

absl::Status CheckNoiseVariances(absl::Span<const double> variances, int64_t count) {
  EGOSIEVE_REQUIRE(InvalidArgument,
                   variances.empty() || static_cast<int64_t>(variances.size()) == count,
                   "%d inputs and %d noise variances", count, variances.size());
  for (size_t i = 0; i < variances.size(); ++i) {
    EGOSIEVE_REQUIRE(InvalidArgument, variances[i] >= 0.0 && std::isfinite(variances[i]),
                     "noise_variances[%d] = %g; it must be finite and not negative", i,
                     variances[i]);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Observations::Validate(int64_t dimension) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(inputs, dimension));
  EGOSIEVE_RETURN_IF_ERROR(CheckTargets(targets, inputs.rows));
  return CheckNoiseVariances(noise_variances, inputs.rows);
}

void PointSet::Append(const Observations& added, int64_t time) {
  const int64_t before = size();
  if (before == 0) outputs = added.outputs();
  if (!noise_variances.empty() || !added.noise_variances.empty()) {
    noise_variances.resize(before, 0.0);
  }
  for (int64_t i = 0; i < added.size(); ++i) {
    const double* x = added.inputs.row(i);
    inputs.insert(inputs.end(), x, x + added.inputs.cols);
    const double* y = added.targets.row(i);
    targets.insert(targets.end(), y, y + outputs);
    if (!noise_variances.empty() || !added.noise_variances.empty()) {
      noise_variances.push_back(added.noise_variance(i));
    }
    insertion_times.push_back(time);
    identities.push_back(next_identity++);
  }
}

void PointSet::Remove(absl::Span<const int64_t> rows) {
  if (rows.empty()) return;
  EraseRows(static_cast<int64_t>(inputs.size()) / size(), rows, inputs);
  EraseRows(outputs, rows, targets);
  if (!noise_variances.empty()) EraseRows(1, rows, noise_variances);
  EraseRows(1, rows, identities);
  EraseRows(1, rows, insertion_times);
}

absl::Status PointSet::Validate(int64_t dimension) const {
  const size_t n = identities.size();
  EGOSIEVE_REQUIRE(InvalidArgument,
                   inputs.size() == n * dimension && insertion_times.size() == n && outputs >= 1 &&
                       targets.size() == n * outputs,
                   "%d values of inputs of dimension %d, %d targets of %d outputs, %d "
                   "identities and %d insertion times do not fit",
                   inputs.size(), dimension, targets.size(), outputs, n, insertion_times.size());
  EGOSIEVE_RETURN_IF_ERROR(observations(dimension).Validate(dimension));
  EGOSIEVE_REQUIRE(InvalidArgument, next_identity >= 0 && next_identity <= kLargestIdentity,
                   "next_identity = %d; it must be in [0, 2^62]", next_identity);
  for (size_t i = 0; i < n; ++i) {
    EGOSIEVE_REQUIRE(
        InvalidArgument,
        identities[i] > (i == 0 ? -1 : identities[i - 1]) && identities[i] < next_identity,
        "identities[%d] = %d; they must increase from 0 to under next_identity = %d", i,
        identities[i], next_identity);
  }
  return absl::OkStatus();
}

PointSet PointsInRows(const Observations& points, absl::Span<const int64_t> rows) {
  PointSet chosen;
  for (const int64_t row : rows) {
    chosen.Append(
        {points.inputs.rows_between(row, row + 1), points.targets.rows_between(row, row + 1),
         points.noise_variances.empty() ? points.noise_variances
                                        : points.noise_variances.subspan(row, 1)},
        0);
  }
  return chosen;
}

absl::Status CheckPoints(ConstMatrixView<double> inputs, int64_t dimension) {
  EGOSIEVE_REQUIRE(InvalidArgument, inputs.rows == 0 || inputs.cols == dimension,
                   "inputs have %d columns; the covariance takes %d", inputs.cols, dimension);
  return kernels::CheckFinite("inputs", inputs);
}

absl::StatusOr<std::vector<double>> TargetsOfLabels(absl::Span<const double> labels) {
  std::vector<double> targets;
  targets.reserve(labels.size());
  for (size_t i = 0; i < labels.size(); ++i) {
    EGOSIEVE_REQUIRE(InvalidArgument, labels[i] >= 0.0 && labels[i] <= 1.0,
                     "labels[%d] = %g; it must be in [0, 1]", i, labels[i]);
    targets.push_back(2.0 * labels[i] - 1.0);
  }
  return targets;
}

template <typename T>
std::vector<double> Widen(kernels::MatrixView<T> inputs) {
  std::vector<double> wide(inputs.rows * inputs.cols);
  for (int64_t i = 0; i < inputs.rows; ++i) {
    std::copy_n(inputs.row(i), inputs.cols, wide.begin() + i * inputs.cols);
  }
  return wide;
}
template std::vector<double> Widen(ConstMatrixView<float>);
template std::vector<double> Widen(ConstMatrixView<double>);

}  // namespace egosieve::gp
