#include "tools/lab/compare/comparison_table.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tools/evaluation/calibration.h"
#include "tools/evaluation/csv_table.h"
#include "tools/evaluation/table_cell.h"
#include "tools/run_folder/json_fields.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;
using Figure = std::optional<double>;

constexpr int kCurvePoints = 200;

Figure Mean(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

using FrameFigureOf = std::optional<double> MethodFrame::*;

std::vector<double> FiguresOf(const MethodResult& method,
                              FrameFigureOf figure = &MethodFrame::auc) {
  std::vector<double> figures;
  for (const MethodFrame& frame : method.frames) {
    if (frame.*figure) figures.push_back(*(frame.*figure));
  }
  return figures;
}

// Mean of the last third minus mean of the first third.
Figure GainOf(const std::vector<double>& aucs) {
  const size_t third = aucs.size() / 3;
  if (third == 0) return std::nullopt;
  const std::vector<double> first(aucs.begin(), aucs.begin() + static_cast<ptrdiff_t>(third));
  const std::vector<double> last(aucs.end() - static_cast<ptrdiff_t>(third), aucs.end());
  return *Mean(last) - *Mean(first);
}

// Differences in frames where both have the figure; the methods see the same frames.
std::vector<double> Differences(const MethodResult& a, const MethodResult& b,
                                FrameFigureOf figure = &MethodFrame::auc) {
  std::vector<double> differences;
  for (size_t i = 0; i < a.frames.size(); ++i) {
    if (a.frames[i].*figure && b.frames[i].*figure) {
      differences.push_back(*(a.frames[i].*figure) - *(b.frames[i].*figure));
    }
  }
  return differences;
}

std::optional<BootstrapInterval> OverDrives(const std::vector<const DriveComparison*>& drives,
                                            size_t index, FrameFigureOf figure,
                                            const BootstrapOptions& bootstrap) {
  std::vector<double> means;
  for (const DriveComparison* drive : drives) {
    const Figure mean = Mean(Differences(drive->methods[0], drive->methods[index], figure));
    if (mean) means.push_back(*mean);
  }
  return SequenceBootstrap(means, bootstrap);
}

// The AUC per frame, minus that of the other method if there is one.
std::vector<FrameFigure> AucsByFrame(const MethodResult& method, const MethodResult* other) {
  std::vector<FrameFigure> aucs;
  for (size_t i = 0; i < method.frames.size(); ++i) {
    const MethodFrame& frame = method.frames[i];
    const Figure less = other == nullptr ? Figure(0.0) : other->frames[i].auc;
    if (frame.auc && less) aucs.push_back({static_cast<double>(frame.index), *frame.auc - *less});
  }
  return aucs;
}

const MethodResult* FindLabels(const DriveComparison& drive) {
  for (const MethodResult& method : drive.methods) {
    if (method.method == "labels") return &method;
  }
  return nullptr;
}

MethodSummary SummariseMethod(const std::vector<const DriveComparison*>& drives, size_t index,
                              const BootstrapOptions& bootstrap) {
  const MethodResult& model = drives.front()->methods[index];
  MethodSummary summary{model.method, model.probabilistic,
                        model.scores, {},
                        {},           {},
                        {},           {},
                        {},           {},
                        0.0,          0.0,
                        {},           {},
                        {},           {}};
  std::vector<double> frame_aucs, drive_aucs, bare_aucs, ious, gains, milliseconds, sizes;
  std::vector<std::vector<FrameFigure>> by_frame, lead_by_frame;
  for (size_t d = 0; d < drives.size(); ++d) {
    const MethodResult& method = drives[d]->methods[index];
    if (d > 0) summary.scores.Merge(method.scores);
    const std::vector<double> aucs = FiguresOf(method);
    frame_aucs.insert(frame_aucs.end(), aucs.begin(), aucs.end());
    if (const Figure mean = Mean(aucs)) drive_aucs.push_back(*mean);
    if (const Figure mean = Mean(FiguresOf(method, &MethodFrame::auc_without_prior))) {
      bare_aucs.push_back(*mean);
    }
    if (const Figure mean = Mean(FiguresOf(method, &MethodFrame::iou))) ious.push_back(*mean);
    by_frame.push_back(AucsByFrame(method, nullptr));
    if (const MethodResult* labels = FindLabels(*drives[d]); labels != nullptr) {
      lead_by_frame.push_back(AucsByFrame(method, labels));
    }
    if (const Figure gain = GainOf(aucs)) gains.push_back(*gain);
    for (const MethodFrame& frame : method.frames) milliseconds.push_back(frame.own_milliseconds);
    sizes.push_back(static_cast<double>(method.frames.back().model_size));
  }
  summary.frame_auc = Mean(frame_aucs);
  summary.drive_auc = Mean(drive_aucs);
  summary.drive_auc_without_prior = Mean(bare_aucs);
  summary.drive_iou = Mean(ious);
  summary.gain = Mean(gains);
  summary.slope = SlopeBootstrap(by_frame, bootstrap);
  summary.slope_of_lead = SlopeBootstrap(lead_by_frame, bootstrap);
  summary.own_milliseconds = milliseconds.empty() ? 0.0 : vision::Median(std::move(milliseconds));
  summary.model_size = Mean(sizes).value_or(0.0);
  return summary;
}

Figure EceOf(const MethodSummary& method) {
  if (!method.probabilistic) return std::nullopt;
  const std::optional<Calibration> calibration = CalibrationOf(method.scores.pooled());
  if (!calibration) return std::nullopt;
  return calibration->expected_calibration_error;
}

Figure ErrorAucOf(const MethodSummary& method) {
  if (!method.scores.has_deviation()) return std::nullopt;
  return method.scores.uncertainty().ErrorAuc();
}

Figure ClassErrorAucOf(const MethodSummary& method) {
  if (!method.probabilistic) return std::nullopt;
  return method.scores.class_uncertainty().ErrorAuc();
}

std::string DifferenceCell(const std::optional<BootstrapInterval>& difference) {
  if (!difference) return "";
  return absl::StrFormat("  %+.4f [%+.4f, %+.4f]", difference->mean, difference->low,
                         difference->high);
}

Json CurveJson(const RocHistogram& scores) {
  Json curve = Json::array();
  for (const OperatingPoint& p : scores.Curve(kCurvePoints)) {
    curve.push_back({p.false_positive_rate, p.recall, p.precision});
  }
  return curve;
}

Json IntervalJson(const std::optional<BootstrapInterval>& interval) {
  if (!interval) return Json();
  return {{"mean", interval->mean},
          {"low", interval->low},
          {"high", interval->high},
          {"share_positive", interval->share_positive},
          {"frames", interval->frames}};
}

Json DriveJson(const DriveComparison& drive) {
  Json json = {{"sequence", drive.sequence.name}, {"truth", drive.sequence.truth}};
  if (!drive.status.ok()) {
    json["error"] = std::string(drive.status.message());
    return json;
  }
  json["pixels"] = drive.pixels;
  json["frames"] = drive.frames;
  json["frames_of_prior"] = drive.frames_of_prior;
  json["frames_without_truth"] = drive.frames_without_truth;
  json["frames_of_void"] = drive.frames_of_void;
  json["frames_of_one_class"] = drive.frames_of_one_class;
  json["points_outside"] = drive.points_outside;
  Json& methods = json["methods"] = Json::array();
  for (const MethodResult& method : drive.methods) {
    Json frames = Json::array();
    for (const MethodFrame& frame : method.frames) {
      frames.push_back({frame.index, OrNull(frame.auc), frame.model_size, frame.own_milliseconds});
    }
    methods.push_back({{"method", method.method},
                       {"mean_auc", OrNull(Mean(FiguresOf(method)))},
                       {"mean_auc_without_prior",
                        OrNull(Mean(FiguresOf(method, &MethodFrame::auc_without_prior)))},
                       {"mean_iou", OrNull(Mean(FiguresOf(method, &MethodFrame::iou)))},
                       {"pooled_auc", OrNull(method.scores.pooled().Auc())},
                       {"frames_index_auc_size_milliseconds", frames}});
  }
  return json;
}

// Reports which parts of the compared drives are not in the figures.
void AppendLeftOut(const std::vector<DriveComparison>& drives, std::string* table) {
  int64_t frames = 0, prior = 0, without = 0, voids = 0, one_class = 0, outside = 0;
  for (const DriveComparison& drive : drives) {
    if (!drive.status.ok()) continue;
    frames += drive.frames;
    prior += drive.frames_of_prior;
    without += drive.frames_without_truth;
    voids += drive.frames_of_void;
    one_class += drive.frames_of_one_class;
    outside += drive.points_outside;
  }
  const auto tell = [&](int64_t count, const char* what) {
    if (count > 0)
      absl::StrAppendFormat(table, "left out: %d of %d frames %s\n", count, frames, what);
  };
  tell(without, "without truth");
  tell(prior, "before the first with labels (the prior)");
  tell(voids, "whose truth is void everywhere or outside the image");
  tell(one_class, "whose truth has one class, from the AUC by frame");
  if (outside > 0) {
    absl::StrAppendFormat(table, "left out: %d labelled points, outside the image\n", outside);
  }
}

void AppendDrives(const std::vector<DriveComparison>& drives, const ComparisonSummary& summary,
                  const char* title, FrameFigureOf figure, std::string* table) {
  absl::StrAppendFormat(table, "\n%s\n%-22s", title, "");
  for (const DriveComparison& drive : drives) {
    if (!drive.status.ok()) continue;
    const std::string& name = drive.sequence.name;
    absl::StrAppendFormat(table, " %14s", name.size() > 14 ? name.substr(name.size() - 14) : name);
  }
  table->push_back('\n');
  for (size_t i = 0; i < summary.methods.size(); ++i) {
    absl::StrAppendFormat(table, "%-22s", summary.methods[i].method);
    for (const DriveComparison& drive : drives) {
      if (!drive.status.ok()) continue;
      absl::StrAppend(table, TableCell(Mean(FiguresOf(drive.methods[i], figure)), 14));
    }
    table->push_back('\n');
  }
}

}  // namespace

std::optional<double> BestIou(const DriveScores& scores) {
  const std::vector<double> ious = scores.MeanIouByThreshold();
  if (ious.empty()) return std::nullopt;
  return *std::max_element(ious.begin(), ious.end());
}

ComparisonSummary Summarise(const std::vector<DriveComparison>& drives,
                            const BootstrapOptions& bootstrap) {
  ComparisonSummary summary;
  std::vector<const DriveComparison*> whole;
  std::vector<double> shared;
  for (const DriveComparison& drive : drives) {
    if (!drive.status.ok()) {
      ++summary.failed;
      continue;
    }
    whole.push_back(&drive);
    summary.at_features.Merge(drive.at_features);
    summary.labels.Add(drive.labels);
    shared.insert(shared.end(), drive.shared_milliseconds.begin(), drive.shared_milliseconds.end());
  }
  summary.drives = static_cast<int>(whole.size());
  summary.shared_milliseconds = shared.empty() ? 0.0 : vision::Median(std::move(shared));
  if (whole.empty()) return summary;
  for (size_t i = 0; i < whole.front()->methods.size(); ++i) {
    MethodSummary method = SummariseMethod(whole, i, bootstrap);
    if (i > 0) {
      std::vector<std::vector<double>> differences;
      for (const DriveComparison* drive : whole) {
        differences.push_back(Differences(drive->methods[0], drive->methods[i]));
      }
      method.difference = BlockBootstrap(differences, bootstrap);
      method.difference_over_drives = OverDrives(whole, i, &MethodFrame::auc, bootstrap);
      method.difference_over_drives_without_prior =
          OverDrives(whole, i, &MethodFrame::auc_without_prior, bootstrap);
      method.iou_difference_over_drives = OverDrives(whole, i, &MethodFrame::iou, bootstrap);
    }
    summary.methods.push_back(std::move(method));
  }
  return summary;
}

std::string ToTable(const std::vector<DriveComparison>& drives, const ComparisonSummary& summary) {
  std::string table = absl::StrFormat(
      "%-22s %8s %8s %8s %8s %8s %8s %8s %8s %8s %8s %8s %8s %8s  %s\n", "method", "AUC", "drives",
      "no prior", "IoU", "pooled", "AP", "IoU best", "ECE", "err. AUC", "by class", "gain",
      "points", "ms own", "first less this: frames, drives, drives without prior, IoU over drives");
  for (const MethodSummary& method : summary.methods) {
    absl::StrAppendFormat(&table, "%-22s", method.method);
    for (const Figure& figure :
         {method.frame_auc, method.drive_auc, method.drive_auc_without_prior, method.drive_iou,
          method.scores.pooled().Auc(), method.scores.Mean(&FrameScores::average_precision),
          BestIou(method.scores), EceOf(method), ErrorAucOf(method), ClassErrorAucOf(method),
          method.gain}) {
      absl::StrAppend(&table, TableCell(figure));
    }
    absl::StrAppendFormat(&table, " %8.0f %8.1f%s%s%s%s\n", method.model_size,
                          method.own_milliseconds, DifferenceCell(method.difference),
                          DifferenceCell(method.difference_over_drives),
                          DifferenceCell(method.difference_over_drives_without_prior),
                          DifferenceCell(method.iou_difference_over_drives));
  }
  absl::StrAppendFormat(&table, "shared by all: %.1f ms a frame for features, labels and inputs\n",
                        summary.shared_milliseconds);
  if (const Figure auc = summary.at_features.Auc()) {
    absl::StrAppendFormat(&table, "RANSAC distance at the features themselves: pooled AUC %.4f\n",
                          *auc);
  }
  AppendDrives(drives, summary, "mean AUC over frames", &MethodFrame::auc, &table);
  AppendDrives(drives, summary, "the same without the location prior",
               &MethodFrame::auc_without_prior, &table);
  AppendDrives(drives, summary, "mean IoU over frames with movers", &MethodFrame::iou, &table);
  AppendLeftOut(drives, &table);
  for (const DriveComparison& drive : drives) {
    if (drive.status.ok()) continue;
    absl::StrAppendFormat(&table, "failed: %s: %s\n", drive.sequence.name, drive.status.message());
  }
  absl::StrAppendFormat(&table, "%d drives compared, %d failed\n", summary.drives, summary.failed);
  return table;
}

void AppendCsv(const std::string& prefix, const std::vector<DriveComparison>& drives,
               std::string* csv) {
  for (const DriveComparison& drive : drives) {
    for (const MethodResult& method : drive.methods) {
      for (size_t i = 0; i < method.frames.size(); ++i) {
        const MethodFrame& frame = method.frames[i];
        absl::StrAppendFormat(csv, "%s%s,%s,%d,%s,%d,%.3f,%.3f\n", prefix,
                              CsvField(drive.sequence.name), CsvField(method.method), frame.index,
                              frame.auc ? absl::StrFormat("%.6f", *frame.auc) : "",
                              frame.model_size, frame.own_milliseconds,
                              drive.shared_milliseconds[i]);
      }
    }
  }
}

Json ToJson(const std::vector<DriveComparison>& drives, const ComparisonSummary& summary) {
  Json methods = Json::array();
  for (const MethodSummary& method : summary.methods) {
    methods.push_back(
        {{"method", method.method},
         {"probabilistic", method.probabilistic},
         {"auc_over_frames", OrNull(method.frame_auc)},
         {"auc_over_drives", OrNull(method.drive_auc)},
         {"auc_over_drives_without_prior", OrNull(method.drive_auc_without_prior)},
         {"iou_over_drives", OrNull(method.drive_iou)},
         {"gain", OrNull(method.gain)},
         {"slope_per_frame", IntervalJson(method.slope)},
         {"slope_of_lead_over_labels_per_frame", IntervalJson(method.slope_of_lead)},
         {"model_size", method.model_size},
         {"own_milliseconds", method.own_milliseconds},
         {"first_less_this", IntervalJson(method.difference)},
         {"first_less_this_over_drives", IntervalJson(method.difference_over_drives)},
         {"first_less_this_over_drives_without_prior",
          IntervalJson(method.difference_over_drives_without_prior)},
         {"first_less_this_iou_over_drives", IntervalJson(method.iou_difference_over_drives)},
         {"scores", method.scores.ToJson()}});
  }
  Json per_drive = Json::array();
  for (const DriveComparison& drive : drives) per_drive.push_back(DriveJson(drive));
  return {{"drives_compared", summary.drives},
          {"failed", summary.failed},
          {"shared_milliseconds", summary.shared_milliseconds},
          {"ransac_at_features",
           {{"pooled_auc", OrNull(summary.at_features.Auc())},
            {"curve_fpr_recall_precision", CurveJson(summary.at_features)}}},
          {"labels",
           {{"static_features", summary.labels.features[0]},
            {"static_features_labelled_dynamic", summary.labels.dynamic[0]},
            {"moving_features", summary.labels.features[1]},
            {"moving_features_labelled_dynamic", summary.labels.dynamic[1]}}},
          {"methods", methods},
          {"drives", per_drive}};
}

}  // namespace egosieve::tools
