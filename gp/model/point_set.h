// The points of a model: inputs, targets of one or several outputs, the noise of each point,
// identities and insertion times, in order of insertion. Removal closes the gaps.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

// Observations, the input of models and objectives.
struct Observations {
  kernels::ConstMatrixView<double> inputs;   // N x D
  kernels::ConstMatrixView<double> targets;  // N x k: k outputs, which share covariance and noise
  absl::Span<const double> noise_variances;  // N, v_i >= 0, on top of sigma_n^2; empty: all 0

  Observations(kernels::ConstMatrixView<double> inputs, kernels::ConstMatrixView<double> targets,
               absl::Span<const double> noise_variances = {})
      : inputs(inputs), targets(targets), noise_variances(noise_variances) {}
  // For one output.
  Observations(kernels::ConstMatrixView<double> inputs, absl::Span<const double> targets,
               absl::Span<const double> noise_variances = {})
      : Observations(inputs, {targets.data(), static_cast<int64_t>(targets.size()), 1},
                     noise_variances) {}

  int64_t size() const { return inputs.rows; }
  int64_t outputs() const { return targets.cols; }
  double noise_variance(int64_t i) const {
    return noise_variances.empty() ? 0.0 : noise_variances[i];
  }
  // InvalidArgument, with row and value, unless the inputs are finite and of this dimension, the
  // targets finite and of the same number, k at least 1, and noise variances finite and not
  // negative.
  absl::Status Validate(int64_t dimension) const;
};

struct PointSet {
  std::vector<double> inputs;           // n x D
  std::vector<double> targets;          // n x k
  std::vector<double> noise_variances;  // n, on top of sigma_n^2; empty: all 0
  std::vector<int64_t> identities;      // increasing
  std::vector<int64_t> insertion_times;
  int64_t next_identity = 0;
  int64_t outputs = 1;  // k

  int64_t size() const { return static_cast<int64_t>(identities.size()); }
  kernels::ConstMatrixView<double> view(int64_t dimension) const {
    return {inputs.data(), size(), dimension};
  }
  kernels::ConstMatrixView<double> target_view() const { return {targets.data(), size(), outputs}; }
  Observations observations(int64_t dimension) const {
    return {view(dimension), target_view(), noise_variances};
  }
  double noise_variance(int64_t i) const {
    return noise_variances.empty() ? 0.0 : noise_variances[i];
  }

  // Without points, k becomes that of the new points; otherwise it must be the same.
  void Append(const Observations& added, int64_t time);
  // rows: strictly increasing, in [0, size()).
  void Remove(absl::Span<const int64_t> rows);

  // InvalidArgument, with the field, unless sizes fit, numbers are finite, noise variances not
  // negative, and identities increasing, not negative and less than next_identity.
  absl::Status Validate(int64_t dimension) const;
};

// The points in these rows.
PointSet PointsInRows(const Observations& points, absl::Span<const int64_t> rows);

// InvalidArgument, with row and value, unless the inputs are finite and of this dimension.
absl::Status CheckPoints(kernels::ConstMatrixView<double> inputs, int64_t dimension);

// y = 2 p - 1. InvalidArgument, with the value, unless every p is in [0, 1].
absl::StatusOr<std::vector<double>> TargetsOfLabels(absl::Span<const double> labels);

// A packed copy in float64.
template <typename T>
std::vector<double> Widen(kernels::MatrixView<T> inputs);

// Removes the given rows (of `width` elements each, 0 for none; strictly increasing) from `values`.
template <typename T>
void EraseRows(int64_t width, absl::Span<const int64_t> rows, std::vector<T>& values) {
  if (width == 0) return;
  const int64_t n = static_cast<int64_t>(values.size()) / width;
  int64_t place = 0;
  size_t next = 0;
  for (int64_t i = 0; i < n; ++i) {
    if (next < rows.size() && rows[next] == i) {
      ++next;
      continue;
    }
    if (place != i) {
      std::copy_n(values.begin() + i * width, width, values.begin() + place * width);
    }
    ++place;
  }
  values.resize(place * width);
}

}  // namespace egosieve::gp
