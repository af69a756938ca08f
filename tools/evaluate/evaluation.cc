#include "tools/evaluate/evaluation.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;

Json OrNull(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

std::optional<double> NumberOrNothing(const Json& value) {
  return value.is_number() ? std::optional<double>(value.get<double>()) : std::nullopt;
}

absl::StatusOr<FrameEvaluation> FrameFromJson(const Json& json) {
  FrameEvaluation frame;
  Json auc;
  JsonFields fields(json, "a frame's entry");
  fields.Read("index", frame.index);
  fields.Read("dynamic_pixels", frame.dynamic_pixels);
  fields.Read("static_pixels", frame.static_pixels);
  fields.Read("void_pixels", frame.void_pixels);
  fields.Read("auc", auc);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  frame.auc = NumberOrNothing(auc);
  return frame;
}

void AppendLeftOut(int64_t count, absl::string_view why, std::string* table) {
  if (count > 0) {
    absl::StrAppendFormat(table, "left out: %d frame%s %s\n", count, count == 1 ? "" : "s", why);
  }
}

}  // namespace

std::string ToText(const Evaluation& evaluation) {
  Json frames = Json::array();
  for (const FrameEvaluation& frame : evaluation.frames) {
    frames.push_back({{"index", frame.index},
                      {"dynamic_pixels", frame.dynamic_pixels},
                      {"static_pixels", frame.static_pixels},
                      {"void_pixels", frame.void_pixels},
                      {"auc", OrNull(frame.auc)}});
  }
  const Json json = {{"truth", evaluation.truth},
                     {"matched_by", evaluation.matched_by},
                     {"pixels", evaluation.pixels},
                     {"pooled_auc", OrNull(evaluation.pooled_auc)},
                     {"mean_auc", OrNull(evaluation.mean_auc)},
                     {"frames_scored", evaluation.frames.size()},
                     {"frames_of_prior", evaluation.frames_of_prior},
                     {"frames_without_map", evaluation.frames_without_map},
                     {"frames_without_mask", evaluation.frames_without_mask},
                     {"scores", evaluation.scores},
                     {"frames", frames}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

absl::StatusOr<Evaluation> EvaluationFromText(absl::string_view text) {
  const Json json = Json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
  Evaluation evaluation;
  Json pooled_auc, mean_auc, frames;
  JsonFields fields(json, "the evaluation");
  fields.Read("truth", evaluation.truth);
  fields.Read("matched_by", evaluation.matched_by);
  fields.Read("pixels", evaluation.pixels);
  fields.Read("pooled_auc", pooled_auc);
  fields.Read("mean_auc", mean_auc);
  fields.Read("frames_of_prior", evaluation.frames_of_prior);
  fields.Read("frames_without_map", evaluation.frames_without_map);
  fields.Read("frames_without_mask", evaluation.frames_without_mask);
  fields.Read("scores", evaluation.scores);
  fields.Read("frames", frames);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  evaluation.pooled_auc = NumberOrNothing(pooled_auc);
  evaluation.mean_auc = NumberOrNothing(mean_auc);
  for (const Json& entry : frames) {
    EGOSIEVE_ASSIGN_OR_RETURN(const FrameEvaluation frame, FrameFromJson(entry));
    evaluation.frames.push_back(frame);
  }
  return evaluation;
}

std::string ToCsv(const Evaluation& evaluation) {
  std::string csv = "frame,dynamic_pixels,static_pixels,void_pixels,auc\n";
  for (const FrameEvaluation& frame : evaluation.frames) {
    absl::StrAppendFormat(&csv, "%d,%d,%d,%d,%s\n", frame.index, frame.dynamic_pixels,
                          frame.static_pixels, frame.void_pixels,
                          frame.auc ? absl::StrFormat("%.6f", *frame.auc) : "");
  }
  return csv;
}

std::string ToTable(const Evaluation& evaluation) {
  std::string table =
      absl::StrFormat("%8s %10s %10s %8s %8s\n", "frame", "dynamic", "static", "void", "AUC");
  int64_t with_auc = 0;
  for (const FrameEvaluation& frame : evaluation.frames) {
    with_auc += frame.auc.has_value();
    absl::StrAppendFormat(&table, "%8d %10d %10d %8d %8s\n", frame.index, frame.dynamic_pixels,
                          frame.static_pixels, frame.void_pixels,
                          frame.auc ? absl::StrFormat("%.4f", *frame.auc) : "-");
  }
  AppendLeftOut(evaluation.frames_of_prior, "before the first that was learnt from (the prior)",
                &table);
  AppendLeftOut(evaluation.frames_without_mask, "without a mask", &table);
  AppendLeftOut(evaluation.frames_without_map, "with a mask, but without a map", &table);
  AppendLeftOut(static_cast<int64_t>(evaluation.frames.size()) - with_auc,
                "whose truth has one class have no AUC of their own; they are in the pooled one",
                &table);
  absl::StrAppendFormat(&table, "scored: %s pixels; masks matched by %s\n", evaluation.pixels,
                        evaluation.matched_by);
  absl::StrAppend(&table, evaluation.scores_summary);
  if (evaluation.mean_auc) {
    absl::StrAppendFormat(&table, "mean AUC %.4f over %d frames\n", *evaluation.mean_auc, with_auc);
  }
  if (evaluation.pooled_auc) {
    absl::StrAppendFormat(&table, "pooled AUC %.4f over %d frames\n", *evaluation.pooled_auc,
                          evaluation.frames.size());
  } else {
    absl::StrAppend(&table, "pooled AUC: none, the truth has one class only\n");
  }
  return table;
}

}  // namespace egosieve::tools
