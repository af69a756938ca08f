// Results of an evaluation: eval.json, and its table as eval.csv.
#ifndef EGOSIEVE_TOOLS_EVALUATE_EVALUATION_H_
#define EGOSIEVE_TOOLS_EVALUATE_EVALUATION_H_

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "tools/evaluation/drive_scores.h"

namespace egosieve::tools {

struct Evaluation {
  std::string truth;       // the folder of masks or the file of tracks
  std::string truth_kind;  // masks, synthetic, tracks
  std::string matched_by;  // name, number or order
  std::string pixels;      // grid, full, or "interpolated from" one of these

  // Area under the ROC curve, of all scored pixels together, and its mean over the frames that have
  // one. Absent if no frame has both classes.
  std::optional<double> pooled_auc;
  std::optional<double> mean_auc;

  std::vector<FrameScores> frames;    // the scored frames
  int64_t frames_of_prior = 0;        // left out: their map is the prior, nothing was learnt yet
  int64_t frames_without_map = 0;     // left out: they have a truth but no map
  int64_t frames_without_mask = 0;    // left out: they have a map but no truth
  int64_t frames_without_points = 0;  // left out: the truth is void or has no point inside
  int64_t points = 0;                 // of tracks, in all frames
  int64_t points_outside = 0;         // of these, left out: outside the image

  nlohmann::ordered_json scores;  // all other figures, as in tools/evaluation/drive_scores.h
  nlohmann::ordered_json masks;   // tools/evaluation/mask_scores.h; null without masks
  std::string scores_summary;     // the main figures as text, one per line; not in the file
};

// Fills the fields that follow from the scores: the frames, both AUCs, scores and their summary.
void Summarise(const DriveScores& scores, Evaluation* evaluation);

std::string ToText(const Evaluation& evaluation);
// DataLoss, naming the field. Among the frames' figures, the AUC and the counts are required.
absl::StatusOr<Evaluation> EvaluationFromText(absl::string_view text);

// One line per frame under a header; an absent figure is an empty field.
std::string ToCsv(const Evaluation& evaluation);

// For people: an aligned table, the frames left out with reasons, and as last line "pooled AUC
// 0.NNN over N frames".
std::string ToTable(const Evaluation& evaluation);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATE_EVALUATION_H_
