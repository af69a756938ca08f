#include "vision/segmentation/agreement_filter.h"

#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"

namespace egosieve::vision {

absl::StatusOr<std::vector<int64_t>> FilterByAgreement(absl::Span<const double> labels,
                                                       absl::Span<const float> predictions,
                                                       bool agreeing) {
  if (labels.size() != predictions.size()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d labels and %d predictions", labels.size(), predictions.size()));
  }
  std::vector<int64_t> kept;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (!(labels[i] >= 0.0 && labels[i] <= 1.0) || std::isnan(predictions[i])) {
      return absl::InvalidArgumentError(
          absl::StrFormat("point %d: label %g, prediction %g; labels must be in [0, 1] and "
                          "predictions numbers",
                          i, labels[i], predictions[i]));
    }
    const bool agrees = (labels[i] >= 0.5) == (static_cast<double>(predictions[i]) >= 0.5);
    if (agrees == agreeing) kept.push_back(static_cast<int64_t>(i));
  }
  return kept;
}

}  // namespace egosieve::vision
