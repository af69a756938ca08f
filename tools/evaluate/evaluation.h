// What an evaluation found: eval.json, and its table as eval.csv.
#ifndef EGOSIEVE_TOOLS_EVALUATE_EVALUATION_H_
#define EGOSIEVE_TOOLS_EVALUATE_EVALUATION_H_

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

struct FrameEvaluation {
  int64_t index = 0;
  int64_t dynamic_pixels = 0;  // of the truth, among those that were scored
  int64_t static_pixels = 0;
  int64_t void_pixels = 0;    // the truth does not say
  std::optional<double> auc;  // absent where the truth has one class
};

struct Evaluation {
  std::string truth;       // the folder of masks
  std::string matched_by;  // name, number or order
  std::string pixels;      // grid or full

  // Area under the ROC curve: of all scored pixels together, and its mean over the frames that have
  // one. Absent where no frame has both classes.
  std::optional<double> pooled_auc;
  std::optional<double> mean_auc;

  std::vector<FrameEvaluation> frames;  // that were scored
  int64_t frames_of_prior = 0;      // left out: their map is the prior, nothing was learnt before
  int64_t frames_without_map = 0;   // left out: they have a mask, but no map
  int64_t frames_without_mask = 0;  // left out: they have a map, but no mask

  nlohmann::ordered_json scores;  // all other figures, as in tools/evaluation/drive_scores.h
  std::string scores_summary;     // the first of them for people, a line each; not in the file
};

std::string ToText(const Evaluation& evaluation);
// DataLoss, naming the field.
absl::StatusOr<Evaluation> EvaluationFromText(absl::string_view text);

// frame,dynamic_pixels,static_pixels,void_pixels,auc; an absent AUC is an empty field.
std::string ToCsv(const Evaluation& evaluation);

// For people: the same as an aligned table, what was left out and why, and, last, the line
// "pooled AUC 0.NNN over N frames".
std::string ToTable(const Evaluation& evaluation);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_EVALUATION_H_
