#include "gp/selection/agreement_filter.h"

#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"

namespace egosieve::gp {
namespace {

absl::Status Check(absl::Span<const double> labels, absl::Span<const float> predictions,
                   const AgreementOptions& options) {
  if (labels.size() != predictions.size()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d labels and %d predictions", labels.size(), predictions.size()));
  }
  if (!(options.undecided_band >= 0.0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("undecided_band = %g; it must not be negative", options.undecided_band));
  }
  for (size_t i = 0; i < labels.size(); ++i) {
    if (!(labels[i] >= 0.0 && labels[i] <= 1.0) || std::isnan(predictions[i])) {
      return absl::InvalidArgumentError(
          absl::StrFormat("point %d: label %g, prediction %g; labels must be in [0, 1] and "
                          "predictions numbers",
                          i, labels[i], predictions[i]));
    }
  }
  return absl::OkStatus();
}

bool Agrees(double label, float prediction) {
  return (label >= 0.5) == (static_cast<double>(prediction) >= 0.5);
}

bool Undecided(float prediction, const AgreementOptions& options) {
  return 2.0 * std::abs(static_cast<double>(prediction) - 0.5) < options.undecided_band;
}

// The points that agree with their predictions, or those that do not; undecided ones in both cases.
absl::StatusOr<std::vector<int64_t>> Filter(absl::Span<const double> labels,
                                            absl::Span<const float> predictions,
                                            const AgreementOptions& options, bool agreeing) {
  EGOSIEVE_RETURN_IF_ERROR(Check(labels, predictions, options));
  std::vector<int64_t> kept;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (Agrees(labels[i], predictions[i]) == agreeing || Undecided(predictions[i], options)) {
      kept.push_back(static_cast<int64_t>(i));
    }
  }
  return kept;
}

}  // namespace

absl::StatusOr<std::vector<int64_t>> FilterByNovelty(absl::Span<const double> labels,
                                                     absl::Span<const float> predictions,
                                                     const AgreementOptions& options) {
  return Filter(labels, predictions, options, false);
}

absl::StatusOr<std::vector<int64_t>> FilterByConsistency(absl::Span<const double> labels,
                                                         absl::Span<const float> predictions,
                                                         const AgreementOptions& options) {
  return Filter(labels, predictions, options, true);
}

}  // namespace egosieve::gp
