#include "tools/suite/suite_table.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "tools/evaluation/calibration.h"
#include "tools/evaluation/csv_table.h"
#include "tools/evaluation/table_cell.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;
using Figure = std::optional<double>;

const DriveScores* ScoresOf(const SequenceResult& result) {
  return result.run ? &result.run->scores : nullptr;
}

template <Figure FrameScores::*kFigure>
Figure MeanOf(const SequenceResult& result) {
  const DriveScores* scores = ScoresOf(result);
  return scores != nullptr ? scores->Mean(kFigure) : std::nullopt;
}

Figure PooledAuc(const SequenceResult& result) {
  const DriveScores* scores = ScoresOf(result);
  return scores != nullptr ? scores->pooled().Auc() : std::nullopt;
}

Figure BestOneThresholdIou(const SequenceResult& result) {
  const DriveScores* scores = ScoresOf(result);
  const std::vector<double> ious =
      scores != nullptr ? scores->MeanIouByThreshold() : std::vector<double>();
  if (ious.empty()) return std::nullopt;
  return *std::max_element(ious.begin(), ious.end());
}

Figure RecallOf(const ObjectTally& objects, int64_t ObjectRecall::*found) {
  const auto all = objects.recall().find("all");
  if (all == objects.recall().end()) return std::nullopt;
  return static_cast<double>(all->second.*found) / static_cast<double>(all->second.objects);
}

Figure Recall(const SequenceResult& result) {
  const DriveScores* scores = ScoresOf(result);
  return scores != nullptr ? RecallOf(scores->objects(), &ObjectRecall::found) : std::nullopt;
}

Figure FalseObjects(const SequenceResult& result) {
  const DriveScores* scores = ScoresOf(result);
  return scores != nullptr ? scores->objects().FalseObjectsPerFrame() : std::nullopt;
}

Figure Ece(const SequenceResult& result) {
  const DriveScores* scores = ScoresOf(result);
  const std::optional<Calibration> calibration =
      scores != nullptr ? CalibrationOf(scores->pooled()) : std::nullopt;
  if (!calibration) return std::nullopt;
  return calibration->expected_calibration_error;
}

Figure ErrorAuc(const SequenceResult& result) {
  const DriveScores* scores = ScoresOf(result);
  return scores != nullptr ? scores->uncertainty().ErrorAuc() : std::nullopt;
}

Figure ClassErrorAuc(const SequenceResult& result) {
  const DriveScores* scores = ScoresOf(result);
  return scores != nullptr ? scores->class_uncertainty().ErrorAuc() : std::nullopt;
}

Figure Sparsification(const SequenceResult& result) {
  const DriveScores* scores = ScoresOf(result);
  return scores != nullptr ? scores->uncertainty().AreaUnderSparsificationError() : std::nullopt;
}

template <Figure (MaskScores::*kFigure)() const>
Figure OfMasks(const SequenceResult& result) {
  return result.run ? (result.run->masks.*kFigure)() : std::nullopt;
}

Figure IdentityF1(const SequenceResult& result) {
  const auto identity = result.run ? result.run->masks.Identity() : std::nullopt;
  return identity ? Figure(identity->idf1) : std::nullopt;
}

Figure Hota(const SequenceResult& result) {
  const auto identity = result.run ? result.run->masks.Identity() : std::nullopt;
  return identity ? Figure(identity->hota) : std::nullopt;
}

Figure MaskRecall(const SequenceResult& result) {
  return result.run ? RecallOf(result.run->masks.objects(), &ObjectRecall::found_at_50)
                    : std::nullopt;
}

Figure MaskFalseObjects(const SequenceResult& result) {
  return result.run ? result.run->masks.objects().FalseObjectsPerFrame() : std::nullopt;
}

Figure Seconds(const SequenceResult& result) {
  if (!(result.seconds_per_frame > 0.0)) return std::nullopt;
  return result.seconds_per_frame;
}

std::vector<GroupKey> GroupsOf(const SequenceResult& result) {
  return {{result.sequence.group, result.profile}, {"all", result.profile}};
}

void AppendSpread(const GroupKey& key, const std::vector<std::optional<Spread>>& figures,
                  std::string* table) {
  const auto row = [&](const char* what, Figure (*of)(const Spread&)) {
    absl::StrAppendFormat(table, "%-32s %-10s %7s", absl::StrCat(what, " ", key.first), key.second,
                          "");
    for (const std::optional<Spread>& figure : figures) {
      absl::StrAppend(table, TableCell(figure ? of(*figure) : std::nullopt));
    }
    table->push_back('\n');
  };
  row("mean", [](const Spread& s) { return Figure(s.mean); });
  if (!std::any_of(figures.begin(), figures.end(),
                   [](const auto& figure) { return figure && figure->count > 1; })) {
    return;
  }
  row("deviation", [](const Spread& s) { return s.deviation; });
  row("least", [](const Spread& s) { return Figure(s.least); });
  row("most", [](const Spread& s) { return Figure(s.most); });
}

Json SpreadJson(const std::vector<std::optional<Spread>>& figures) {
  Json json = Json::object();
  for (size_t i = 0; i < figures.size(); ++i) {
    Json& entry = json[SuiteFigures()[i].name];
    if (figures[i]) {
      entry = {{"sequences", figures[i]->count},
               {"mean", figures[i]->mean},
               {"deviation", OrNull(figures[i]->deviation)},
               {"least", figures[i]->least},
               {"most", figures[i]->most}};
    }
  }
  return json;
}

}  // namespace

const std::vector<SuiteFigure>& SuiteFigures() {
  static const auto& figures = *new std::vector<SuiteFigure>{
      {"mean_auc", "AUC", MeanOf<&FrameScores::auc>},
      {"pooled_auc", "pooled", PooledAuc},
      {"mean_average_precision", "AP", MeanOf<&FrameScores::average_precision>},
      {"mean_iou", "IoU", MeanOf<&FrameScores::iou>},
      {"mean_f", "F", MeanOf<&FrameScores::f>},
      {"mean_iou_best_threshold", "IoU best", BestOneThresholdIou},
      {"mean_boundary_f", "bound. F", MeanOf<&FrameScores::boundary_f>},
      {"object_recall", "recall", Recall},
      {"false_objects_per_frame", "false o.", FalseObjects},
      {"expected_calibration_error", "ECE", Ece},
      {"brier", "Brier", MeanOf<&FrameScores::brier>},
      {"log_loss", "log loss", MeanOf<&FrameScores::log_loss>},
      {"area_under_sparsification_error", "AUSE", Sparsification},
      {"error_auc", "err. AUC", ErrorAuc},
      {"class_error_auc", "by class", ClassErrorAuc},
      {"mask_j", "mask J", OfMasks<&MaskScores::MeanJ>},
      {"mask_boundary_f", "mask F", OfMasks<&MaskScores::MeanF>},
      {"mask_temporal_instability", "mask T", OfMasks<&MaskScores::MeanT>},
      {"truth_temporal_instability", "true T", OfMasks<&MaskScores::TruthT>},
      {"mask_object_recall", "m. rec.", MaskRecall},
      {"mask_false_objects_per_frame", "m. false", MaskFalseObjects},
      {"idf1", "IDF1", IdentityF1},
      {"hota", "HOTA", Hota},
      {"seconds_per_frame", "s/frame", Seconds},
  };
  return figures;
}

std::optional<Spread> SpreadOf(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  Spread spread;
  spread.count = static_cast<int>(values.size());
  for (const double value : values) spread.mean += value / static_cast<double>(values.size());
  spread.least = *std::min_element(values.begin(), values.end());
  spread.most = *std::max_element(values.begin(), values.end());
  if (values.size() > 1) {
    double squares = 0.0;
    for (const double value : values) squares += (value - spread.mean) * (value - spread.mean);
    spread.deviation = std::sqrt(squares / static_cast<double>(values.size() - 1));
  }
  return spread;
}

SuiteSummary SummariseSuite(const std::vector<SequenceResult>& results) {
  SuiteSummary summary;
  std::map<GroupKey, std::vector<std::vector<double>>> values;
  std::map<GroupKey, std::vector<std::vector<double>>> ious;
  for (const SequenceResult& result : results) {
    summary.failed += !result.status.ok();
    for (const GroupKey& key : GroupsOf(result)) {
      auto& own = values[key];
      own.resize(SuiteFigures().size());
      for (size_t i = 0; i < own.size(); ++i) {
        if (const Figure value = SuiteFigures()[i].of(result)) own[i].push_back(*value);
      }
      // Points have no share of the image: only masks are scored at one threshold.
      if (!result.run || result.run->evaluation.truth_kind == "tracks") continue;
      std::vector<double> by_threshold = result.run->scores.MeanIouByThreshold();
      if (!by_threshold.empty()) ious[key].push_back(std::move(by_threshold));
    }
  }
  for (const auto& [key, figures] : values) {
    for (const std::vector<double>& figure : figures) {
      summary.figures[key].push_back(SpreadOf(figure));
    }
  }
  for (const auto& [key, sequences] : ious) {
    std::vector<double>& mean = summary.iou_by_threshold[key];
    mean.assign(kThresholdSteps, 0.0);
    for (const std::vector<double>& one : sequences) {
      for (int step = 0; step < kThresholdSteps; ++step) {
        mean[step] += one[step] / static_cast<double>(sequences.size());
      }
    }
  }
  return summary;
}

std::string ToTable(const SequenceList& list, const std::vector<SequenceResult>& results,
                    const SuiteSummary& summary) {
  std::string table = absl::StrFormat("%-32s %-10s %7s", "sequence", "profile", "frames");
  for (const SuiteFigure& figure : SuiteFigures()) {
    absl::StrAppendFormat(&table, " %8s", figure.heading);
  }
  table.push_back('\n');
  for (const SequenceResult& result : results) {
    if (!result.run) continue;
    absl::StrAppendFormat(&table, "%-32s %-10s %7d", result.sequence.name, result.profile,
                          result.run->evaluation.frames.size());
    for (const SuiteFigure& figure : SuiteFigures())
      absl::StrAppend(&table, TableCell(figure.of(result)));
    table.push_back('\n');
  }
  for (const auto& [key, figures] : summary.figures) AppendSpread(key, figures, &table);
  for (const auto& [key, ious] : summary.iou_by_threshold) {
    const auto best = std::max_element(ious.begin(), ious.end());
    absl::StrAppendFormat(
        &table, "one threshold for %s, %s: %.2f gives a mean IoU of %.4f (0.50: %.4f)\n", key.first,
        key.second, ThresholdStep(static_cast<int>(best - ious.begin())), *best, ious[9]);
  }
  for (const SequenceResult& result : results) {
    if (result.status.ok()) continue;
    absl::StrAppendFormat(&table, "failed: %s, %s: %s\n", result.sequence.name, result.profile,
                          result.status.message());
  }
  if (!list.without_truth.empty()) {
    absl::StrAppendFormat(&table, "left out: %d folders with frames, but without truth: %s\n",
                          list.without_truth.size(), absl::StrJoin(list.without_truth, ", "));
  }
  absl::StrAppendFormat(&table, "%d of %d runs scored, %d failed\n",
                        results.size() - summary.failed, results.size(), summary.failed);
  return table;
}

std::string ToMarkdown(const std::vector<SequenceResult>& results) {
  const auto number = [](const Figure& value) {
    return value ? absl::StrFormat("%.3f", *value) : std::string("-");
  };
  struct Folder {
    int scored = 0, all = 0;
    std::vector<double> auc, j;
  };
  std::map<GroupKey, Folder> folders;
  for (const SequenceResult& result : results) {
    const bool has_masks = result.run && result.run->evaluation.truth_kind != "tracks";
    for (const GroupKey& key : GroupsOf(result)) {
      Folder& folder = folders[key];
      ++folder.all;
      folder.scored += result.run.has_value();
      if (const Figure auc = MeanOf<&FrameScores::auc>(result)) folder.auc.push_back(*auc);
      if (!has_masks) continue;
      if (const Figure j = MeanOf<&FrameScores::iou>(result)) folder.j.push_back(*j);
    }
  }
  std::string table =
      "| folder | profile | sequences | AUC, mean | AUC, least | J, mean | J, least |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const auto& [key, folder] : folders) {
    const auto auc = SpreadOf(folder.auc), j = SpreadOf(folder.j);
    const auto of = [&](const std::optional<Spread>& spread, double Spread::*field) {
      return number(spread ? Figure((*spread).*field) : std::nullopt);
    };
    absl::StrAppend(&table, "| ", key.first, " | ", key.second, " | ", folder.scored, " of ",
                    folder.all, " | ", of(auc, &Spread::mean), " | ", of(auc, &Spread::least),
                    " | ", of(j, &Spread::mean), " | ", of(j, &Spread::least), " |\n");
  }
  return table;
}

std::string ToCsv(const std::vector<SequenceResult>& results) {
  std::string csv = "sequence,group,profile,frames,error";
  for (const SuiteFigure& figure : SuiteFigures()) absl::StrAppend(&csv, ",", figure.name);
  csv.push_back('\n');
  for (const SequenceResult& result : results) {
    absl::StrAppendFormat(&csv, "%s,%s,%s,%d,%s", CsvField(result.sequence.name),
                          CsvField(result.sequence.group), CsvField(result.profile), result.frames,
                          result.status.ok() ? "" : absl::StatusCodeToString(result.status.code()));
    for (const SuiteFigure& figure : SuiteFigures()) {
      const Figure value = figure.of(result);
      absl::StrAppend(&csv, ",", value ? absl::StrFormat("%.6f", *value) : "");
    }
    csv.push_back('\n');
  }
  return csv;
}

Json ToJson(const SequenceList& list, const std::vector<SequenceResult>& results,
            const SuiteSummary& summary) {
  Json sequences = Json::array();
  for (const SequenceResult& result : results) {
    Json entry = {
        {"sequence", result.sequence.name},
        {"group", result.sequence.group},
        {"profile", result.profile},
        {"truth", result.sequence.truth},
        {"error", result.status.ok() ? Json() : Json(std::string(result.status.message()))},
        {"frames", result.frames}};
    for (const SuiteFigure& figure : SuiteFigures()) entry[figure.name] = OrNull(figure.of(result));
    if (result.run) {
      entry["frames_scored"] = result.run->evaluation.frames.size();
      entry["pixels"] = result.run->evaluation.pixels;
      entry["scores"] = result.run->evaluation.scores;
      entry["further"] = ToJson(result.further);
    }
    sequences.push_back(std::move(entry));
  }
  Json groups = Json::array();
  for (const auto& [key, figures] : summary.figures) {
    const auto ious = summary.iou_by_threshold.find(key);
    groups.push_back({{"group", key.first},
                      {"profile", key.second},
                      {"figures", SpreadJson(figures)},
                      {"mean_iou_at_0.05_to_0.95",
                       ious == summary.iou_by_threshold.end() ? Json() : Json(ious->second)}});
  }
  return {{"failed", summary.failed},
          {"without_truth", list.without_truth},
          {"groups", groups},
          {"sequences", sequences}};
}

}  // namespace egosieve::tools
