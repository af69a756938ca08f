#include "gp/model/point_set.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

using kernels::ConstMatrixView;

constexpr int64_t kLargestIdentity = int64_t{1} << 62;

}  // namespace

void PointSet::Append(ConstMatrixView<double> new_inputs, absl::Span<const double> new_targets,
                      int64_t frame) {
  for (int64_t i = 0; i < new_inputs.rows; ++i) {
    inputs.insert(inputs.end(), new_inputs.row(i), new_inputs.row(i) + new_inputs.cols);
    targets.push_back(new_targets[i]);
    birth_frames.push_back(frame);
    identities.push_back(next_identity++);
  }
}

void PointSet::Remove(absl::Span<const int64_t> rows) {
  if (rows.empty()) return;
  EraseRows(static_cast<int64_t>(inputs.size()) / size(), rows, inputs);
  EraseRows(1, rows, targets);
  EraseRows(1, rows, identities);
  EraseRows(1, rows, birth_frames);
}

absl::Status PointSet::Validate(int64_t dimension) const {
  const size_t n = targets.size();
  if (inputs.size() != n * dimension || identities.size() != n || birth_frames.size() != n) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d values of inputs of dimension %d, %d targets, %d identities and %d "
                        "birth frames do not fit",
                        inputs.size(), dimension, n, identities.size(), birth_frames.size()));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckPoints(view(dimension), dimension));
  EGOSIEVE_RETURN_IF_ERROR(CheckTargets(targets, size()));
  if (!(next_identity >= 0 && next_identity <= kLargestIdentity)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("next_identity = %d; it must be in [0, 2^62]", next_identity));
  }
  for (size_t i = 0; i < n; ++i) {
    if (!(identities[i] > (i == 0 ? -1 : identities[i - 1]) && identities[i] < next_identity)) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "identities[%d] = %d; they must increase from 0 to under next_identity = %d", i,
          identities[i], next_identity));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckPoints(ConstMatrixView<double> inputs, int64_t dimension) {
  if (inputs.rows > 0 && inputs.cols != dimension) {
    return absl::InvalidArgumentError(
        absl::StrFormat("inputs have %d columns; the covariance takes %d", inputs.cols, dimension));
  }
  for (int64_t i = 0; i < inputs.rows; ++i) {
    for (int64_t d = 0; d < inputs.cols; ++d) {
      if (!std::isfinite(inputs(i, d))) {
        return absl::InvalidArgumentError(
            absl::StrFormat("inputs(%d, %d) = %g; it must be finite", i, d, inputs(i, d)));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status CheckTargets(absl::Span<const double> targets, int64_t count) {
  if (static_cast<int64_t>(targets.size()) != count) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d inputs and %d labels or targets", count, targets.size()));
  }
  for (size_t i = 0; i < targets.size(); ++i) {
    if (!std::isfinite(targets[i])) {
      return absl::InvalidArgumentError(
          absl::StrFormat("targets[%d] = %g; it must be finite", i, targets[i]));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckRows(absl::Span<const int64_t> rows, int64_t size) {
  for (size_t i = 0; i < rows.size(); ++i) {
    if (!(rows[i] >= 0 && rows[i] < size) || (i > 0 && rows[i] <= rows[i - 1])) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "rows[%d] = %d; rows must be strictly increasing and in [0, %d)", i, rows[i], size));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<double>> TargetsOfLabels(absl::Span<const double> labels) {
  std::vector<double> targets;
  targets.reserve(labels.size());
  for (size_t i = 0; i < labels.size(); ++i) {
    if (!(labels[i] >= 0.0 && labels[i] <= 1.0)) {
      return absl::InvalidArgumentError(
          absl::StrFormat("labels[%d] = %g; it must be in [0, 1]", i, labels[i]));
    }
    targets.push_back(2.0 * labels[i] - 1.0);
  }
  return targets;
}

std::vector<double> Widen(ConstMatrixView<float> inputs) {
  std::vector<double> wide(inputs.rows * inputs.cols);
  for (int64_t i = 0; i < inputs.rows; ++i) {
    std::copy_n(inputs.row(i), inputs.cols, wide.begin() + i * inputs.cols);
  }
  return wide;
}

}  // namespace egosieve::gp
