// The labelled points that a model holds: inputs, targets, identities and birth frames, in the
// order in which they came. Removal closes the gaps.
#ifndef EGOSIEVE_GP_MODEL_POINT_SET_H_
#define EGOSIEVE_GP_MODEL_POINT_SET_H_

#include <algorithm>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

struct PointSet {
  std::vector<double> inputs;  // n x D
  std::vector<double> targets;
  std::vector<int64_t> identities;  // increasing
  std::vector<int64_t> birth_frames;
  int64_t next_identity = 0;

  int64_t size() const { return static_cast<int64_t>(targets.size()); }
  kernels::ConstMatrixView<double> view(int64_t dimension) const {
    return {inputs.data(), size(), dimension};
  }

  void Append(kernels::ConstMatrixView<double> new_inputs, absl::Span<const double> new_targets,
              int64_t frame);
  // rows: as CheckRows wants them.
  void Remove(absl::Span<const int64_t> rows);

  // InvalidArgument, naming the field, unless sizes fit, numbers are finite, and identities are
  // increasing, not negative and under next_identity.
  absl::Status Validate(int64_t dimension) const;
};

// InvalidArgument, naming row and value, unless the inputs are finite and of this dimension, and
// the targets finite and as many.
absl::Status CheckPoints(kernels::ConstMatrixView<double> inputs, int64_t dimension);
absl::Status CheckTargets(absl::Span<const double> targets, int64_t count);
// InvalidArgument unless rows are strictly increasing and in [0, size).
absl::Status CheckRows(absl::Span<const int64_t> rows, int64_t size);

// y = 2 p - 1. InvalidArgument, naming the value, unless every p is in [0, 1].
absl::StatusOr<std::vector<double>> TargetsOfLabels(absl::Span<const double> labels);

// The same numbers in float64.
std::vector<double> Widen(kernels::ConstMatrixView<float> inputs);

// Takes the named rows (of `width` elements each; strictly increasing) out of `values`.
template <typename T>
void EraseRows(int64_t width, absl::Span<const int64_t> rows, std::vector<T>& values) {
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

#endif  // EGOSIEVE_GP_MODEL_POINT_SET_H_
