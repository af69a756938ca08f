#include "tools/lab/evaluate_features/feature_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tools/evaluation/roc.h"
#include "tools/evaluation/table_cell.h"

namespace egosieve::tools {
namespace {

using nlohmann::ordered_json;
using vision::ChoiceVerdict;

constexpr struct {
  const char* name;
  std::optional<double> (*of)(const FeatureFrame&);
} kFigures[] = {
    {"residual", ResidualAuc}, {"rejected", RejectedAuc}, {"label", LabelAuc}, {"plain", PlainAuc}};

struct Choices {
  int64_t better = 0, tied = 0, worse = 0, not_below = 0;

  explicit Choices(const SequenceScore& score)
      : better(score.CountVerdicts(ChoiceVerdict::kBetter)),
        tied(score.CountVerdicts(ChoiceVerdict::kTied)),
        worse(score.CountVerdicts(ChoiceVerdict::kWorse)),
        not_below(score.CountNotBelow()) {}
  Choices() = default;

  void operator+=(const Choices& other) {
    better += other.better;
    tied += other.tied;
    worse += other.worse;
    not_below += other.not_below;
  }
  int64_t judged() const { return better + tied + worse; }
};

std::string Cell(const std::optional<double>& value) { return TableCell(value, 8, 3); }

std::string Line(const std::string& name, size_t width, const std::optional<double> (&means)[4],
                 int64_t frames, int64_t unlabelled, const Choices& choices) {
  std::string line = absl::StrFormat("%-*s %6d", static_cast<int>(width), name, frames);
  for (const auto& mean : means) line += Cell(mean);
  absl::StrAppend(
      &line,
      absl::StrFormat(" %10d %7d %5d %6d", unlabelled, choices.better, choices.tied, choices.worse),
      Cell(Ratio(choices.not_below, choices.judged())), "\n");
  return line;
}

ordered_json Json(std::optional<double> value) {
  return value.has_value() ? ordered_json(*value) : ordered_json();
}

ordered_json Json(const Choices& choices) {
  return {{"judged", choices.judged()},
          {"better", choices.better},
          {"tied", choices.tied},
          {"worse", choices.worse},
          {"not_below", choices.not_below},
          {"share_not_below", Json(Ratio(choices.not_below, choices.judged()))},
          {"share_better_of_untied", Json(Ratio(choices.better, choices.better + choices.worse))}};
}

const char* Name(std::optional<ChoiceVerdict> verdict) {
  if (!verdict.has_value()) return nullptr;
  if (*verdict == ChoiceVerdict::kTied) return "tied";
  return *verdict == ChoiceVerdict::kBetter ? "better" : "worse";
}

ordered_json Json(const FeatureFrame& frame) {
  ordered_json json = {{"index", frame.index},
                       {"outcome", frame.outcome},
                       {"reason", frame.reason},
                       {"motion_model", vision::Name(frame.motion_model)},
                       {"points", frame.score.scored_count},
                       {"movers", frame.score.mover_count}};
  for (const auto& figure : kFigures) {
    json[absl::StrCat(figure.name, "_auc")] = Json(figure.of(frame));
  }
  const char* verdict = Name(frame.verdict);
  json["choice"] = verdict == nullptr ? ordered_json() : ordered_json(verdict);
  return json;
}

ordered_json Json(const SequenceScore& score) {
  ordered_json json = {{"name", score.name},
                       {"frames_scored", score.frames.size()},
                       {"frames_without_labels", score.CountUnlabelled()},
                       {"frames_without_truth", score.frames_without_truth},
                       {"frames_damaged", score.frames_damaged},
                       {"motion_models", score.CountMotionModels()}};
  for (const auto& figure : kFigures) {
    json[absl::StrCat(figure.name, "_auc")] = Json(MeanAuc(score.frames, figure.of));
  }
  json["choice"] = Json(Choices(score));
  json["frames"] = ordered_json::array();
  for (const FeatureFrame& frame : score.frames) json["frames"].push_back(Json(frame));
  return json;
}

// Mean over sequences of each sequence's mean.
std::optional<double> MeanOfMeans(const std::vector<SequenceScore>& scores, const AucOf& auc_of) {
  double sum = 0.0;
  int64_t count = 0;
  for (const SequenceScore& score : scores) {
    const std::optional<double> mean = MeanAuc(score.frames, auc_of);
    if (!mean.has_value()) continue;
    sum += *mean;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

}  // namespace

std::string ToTable(const std::vector<SequenceScore>& scores) {
  size_t width = 8;
  for (const SequenceScore& score : scores) width = std::max(width, score.name.size());
  std::string table = absl::StrFormat(
      "%-*s %6s%9s%9s%9s%9s %10s %7s %5s %6s %8s\n", static_cast<int>(width), "sequence", "frames",
      "residual", "rejected", "label", "plain", "unlabelled", "better", "tied", "worse", "choice");
  Choices all;
  std::optional<double> means[4];
  int64_t frames = 0, unlabelled = 0;
  for (const SequenceScore& score : scores) {
    for (size_t i = 0; i < 4; ++i) means[i] = MeanAuc(score.frames, kFigures[i].of);
    const Choices choices(score);
    table += Line(score.name, width, means, static_cast<int64_t>(score.frames.size()),
                  score.CountUnlabelled(), choices);
    all += choices;
    frames += static_cast<int64_t>(score.frames.size());
    unlabelled += score.CountUnlabelled();
  }
  for (size_t i = 0; i < 4; ++i) means[i] = MeanOfMeans(scores, kFigures[i].of);
  table += Line("all", width, means, frames, unlabelled, all);
  absl::StrAppend(
      &table,
      "AUC of movers against the rest, mean over frames: residual and rejected, of the motion "
      "model that was chosen and of the other; label, of the probability; plain, of OpenCV's "
      "RANSAC "
      "distance.\n",
      absl::StrFormat("Choice: better or worse by more than %.2f in AUC than the other model, else "
                      "tied; the last column is the share of frames whose chosen model is not "
                      "below the other at all.\n",
                      vision::kTiedAuc));
  return table;
}

std::string ToJson(const std::vector<SequenceScore>& scores,
                   const EvaluateFeaturesOptions& options) {
  ordered_json json = {{"frame_gap", options.labeller.frame_gap},
                       {"every", options.every},
                       {"seed", options.labeller.seed},
                       {"tied_auc", vision::kTiedAuc},
                       {"sequences", ordered_json::array()}};
  Choices choices;
  for (const SequenceScore& score : scores) {
    json["sequences"].push_back(Json(score));
    choices += Choices(score);
  }
  ordered_json all;
  for (const auto& figure : kFigures) {
    all[absl::StrCat(figure.name, "_auc")] = Json(MeanOfMeans(scores, figure.of));
  }
  all["choice"] = Json(choices);
  json["all"] = all;
  return json.dump(2) + "\n";
}

}  // namespace egosieve::tools
