// What the report shows of eval.json, which egosieve-eval writes (tools/evaluate/evaluation.py).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

struct EvaluatedFrame {
  int64_t index = 0;
  int64_t dynamic_pixels = 0;  // of the truth
  int64_t static_pixels = 0;
  double auc = 0.0;  // area under the ROC curve; NaN: the truth has one class
};

struct EvaluationFile {
  std::string truth;        // path
  std::string pixels;       // grid, full, or "interpolated from" one of these
  double pooled_auc = 0.0;  // of all scored pixels together; NaN: none
  double mean_auc = 0.0;    // over the frames that have one; NaN: none
  std::vector<EvaluatedFrame> frames;
  int64_t frames_of_prior = 0;      // left out: their map is the prior
  int64_t frames_without_map = 0;   // left out: they have a truth but no map
  int64_t frames_without_mask = 0;  // left out: they have a map but no truth
};

// DataLoss, naming the field.
absl::StatusOr<EvaluationFile> ParseEvaluation(absl::string_view text);

}  // namespace egosieve::tools
