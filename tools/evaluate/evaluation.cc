#include "tools/evaluate/evaluation.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;

// A figure of a frame: its name in files and its heading in the table.
struct Figure {
  const char* name;
  const char* heading;
  std::optional<double> FrameScores::*value;
};

constexpr Figure kFigures[] = {
    {"auc", "AUC", &FrameScores::auc},
    {"average_precision", "AP", &FrameScores::average_precision},
    {"iou", "IoU", &FrameScores::iou},
    {"f", "F", &FrameScores::f},
    {"boundary_f", "bound. F", &FrameScores::boundary_f},
    {"best_iou", "best IoU", &FrameScores::best_iou},
    {"false_positive_rate", "FP rate", &FrameScores::false_positive_rate},
    {"brier", "Brier", &FrameScores::brier},
    {"log_loss", "log loss", &FrameScores::log_loss},
};

std::optional<double> NumberOrNothing(const Json& value) {
  return value.is_number() ? std::optional<double>(value.get<double>()) : std::nullopt;
}

Json FrameToJson(const FrameScores& frame) {
  Json json = {{"index", frame.index},
               {"dynamic_pixels", frame.dynamic_pixels},
               {"static_pixels", frame.static_pixels},
               {"void_pixels", frame.void_pixels}};
  for (const Figure& figure : kFigures) json[figure.name] = OrNull(frame.*figure.value);
  return json;
}

absl::StatusOr<FrameScores> FrameFromJson(const Json& json) {
  FrameScores frame;
  Json auc;
  JsonFields fields(json, "a frame's entry");
  fields.Read("index", frame.index);
  fields.Read("dynamic_pixels", frame.dynamic_pixels);
  fields.Read("static_pixels", frame.static_pixels);
  fields.Read("void_pixels", frame.void_pixels);
  fields.Read("auc", auc);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  frame.has_movers = frame.dynamic_pixels > 0;
  for (const Figure& figure : kFigures) {
    const auto field = json.find(figure.name);
    if (field != json.end()) frame.*figure.value = NumberOrNothing(*field);
  }
  return frame;
}

void AppendLeftOut(int64_t count, absl::string_view why, std::string* table) {
  if (count > 0) {
    absl::StrAppendFormat(table, "left out: %d frame%s %s\n", count, count == 1 ? "" : "s", why);
  }
}

std::string LeftOut(const Evaluation& evaluation) {
  std::string text;
  const bool tracks = evaluation.truth_kind == "tracks";
  AppendLeftOut(evaluation.frames_of_prior, "before the first that was learnt from (the prior)",
                &text);
  AppendLeftOut(evaluation.frames_without_mask,
                tracks ? "without a labelled point" : "without a mask", &text);
  AppendLeftOut(
      evaluation.frames_without_map,
      tracks ? "with labelled points, but without a map" : "with a mask, but without a map", &text);
  AppendLeftOut(
      evaluation.frames_without_points,
      tracks ? "whose labelled points lie outside the image" : "whose mask is void everywhere",
      &text);
  if (evaluation.points_outside > 0) {
    absl::StrAppendFormat(&text, "left out: %d of %d labelled points, outside the image\n",
                          evaluation.points_outside, evaluation.points);
  }
  return text;
}

}  // namespace

void Summarise(const DriveScores& scores, Evaluation* evaluation) {
  evaluation->pooled_auc = scores.pooled().Auc();
  evaluation->mean_auc = scores.Mean(&FrameScores::auc);
  evaluation->frames = scores.frames();
  evaluation->scores = scores.ToJson();
  evaluation->scores_summary = scores.Summary();
}

std::string ToText(const Evaluation& evaluation) {
  Json frames = Json::array();
  for (const FrameScores& frame : evaluation.frames) frames.push_back(FrameToJson(frame));
  const Json json = {{"truth", evaluation.truth},
                     {"truth_kind", evaluation.truth_kind},
                     {"matched_by", evaluation.matched_by},
                     {"pixels", evaluation.pixels},
                     {"pooled_auc", OrNull(evaluation.pooled_auc)},
                     {"mean_auc", OrNull(evaluation.mean_auc)},
                     {"frames_scored", evaluation.frames.size()},
                     {"frames_of_prior", evaluation.frames_of_prior},
                     {"frames_without_map", evaluation.frames_without_map},
                     {"frames_without_mask", evaluation.frames_without_mask},
                     {"frames_without_points", evaluation.frames_without_points},
                     {"points", evaluation.points},
                     {"points_outside", evaluation.points_outside},
                     {"scores", evaluation.scores},
                     {"masks", evaluation.masks},
                     {"frames", frames}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

absl::StatusOr<Evaluation> EvaluationFromText(absl::string_view text) {
  const Json json = Json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
  Evaluation evaluation;
  Json pooled_auc, mean_auc, frames;
  JsonFields fields(json, "the evaluation");
  fields.Read("truth", evaluation.truth);
  fields.Read("truth_kind", evaluation.truth_kind);
  fields.Read("matched_by", evaluation.matched_by);
  fields.Read("pixels", evaluation.pixels);
  fields.Read("pooled_auc", pooled_auc);
  fields.Read("mean_auc", mean_auc);
  fields.Read("frames_of_prior", evaluation.frames_of_prior);
  fields.Read("frames_without_map", evaluation.frames_without_map);
  fields.Read("frames_without_mask", evaluation.frames_without_mask);
  fields.Read("frames_without_points", evaluation.frames_without_points);
  fields.Read("points", evaluation.points);
  fields.Read("points_outside", evaluation.points_outside);
  fields.Read("scores", evaluation.scores);
  fields.ReadIfThere("masks", evaluation.masks);
  fields.Read("frames", frames);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  evaluation.pooled_auc = NumberOrNothing(pooled_auc);
  evaluation.mean_auc = NumberOrNothing(mean_auc);
  for (const Json& entry : frames) {
    EGOSIEVE_ASSIGN_OR_RETURN(const FrameScores frame, FrameFromJson(entry));
    evaluation.frames.push_back(frame);
  }
  return evaluation;
}

std::string ToCsv(const Evaluation& evaluation) {
  std::string csv = "frame,dynamic_pixels,static_pixels,void_pixels";
  for (const Figure& figure : kFigures) absl::StrAppend(&csv, ",", figure.name);
  csv.push_back('\n');
  for (const FrameScores& frame : evaluation.frames) {
    absl::StrAppendFormat(&csv, "%d,%d,%d,%d", frame.index, frame.dynamic_pixels,
                          frame.static_pixels, frame.void_pixels);
    for (const Figure& figure : kFigures) {
      const std::optional<double>& value = frame.*figure.value;
      absl::StrAppend(&csv, ",", value ? absl::StrFormat("%.6f", *value) : "");
    }
    csv.push_back('\n');
  }
  return csv;
}

std::string ToTable(const Evaluation& evaluation) {
  std::string table = absl::StrFormat("%8s %10s %10s %8s", "frame", "dynamic", "static", "void");
  for (const Figure& figure : kFigures) absl::StrAppendFormat(&table, " %8s", figure.heading);
  table.push_back('\n');
  int64_t with_auc = 0;
  for (const FrameScores& frame : evaluation.frames) {
    with_auc += frame.auc.has_value();
    absl::StrAppendFormat(&table, "%8d %10d %10d %8d", frame.index, frame.dynamic_pixels,
                          frame.static_pixels, frame.void_pixels);
    for (const Figure& figure : kFigures) {
      const std::optional<double>& value = frame.*figure.value;
      absl::StrAppendFormat(&table, " %8s", value ? absl::StrFormat("%.4f", *value) : "-");
    }
    table.push_back('\n');
  }
  absl::StrAppend(&table, LeftOut(evaluation));
  AppendLeftOut(
      static_cast<int64_t>(evaluation.frames.size()) - with_auc,
      evaluation.pooled_auc
          ? "whose truth has one class have no AUC of their own; they are in the pooled one"
          : "whose truth has one class, from AUC, average precision and IoU",
      &table);
  absl::StrAppendFormat(&table, "scored: %s pixels; %s matched by %s\n", evaluation.pixels,
                        evaluation.truth_kind == "tracks" ? "tracks" : "masks",
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
