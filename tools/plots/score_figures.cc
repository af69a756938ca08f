#include "tools/plots/score_figures.h"

#include <limits>

#include "tools/evaluation/calibration.h"

namespace egosieve::tools {
namespace {

constexpr int kPoints = 200;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::pair<double, double> kUnit = {0.0, 1.0};

Figure UnitFigure(const char* id, const char* title, const char* caption, const char* x_label,
                  const char* y_label) {
  Figure figure{id, title, caption, x_label, y_label};
  figure.x_range = kUnit;
  figure.y_range = kUnit;
  return figure;
}

void AddSeries(Series series, Figure& figure) {
  if (!series.x.empty()) figure.series.push_back(std::move(series));
}

}  // namespace

Series RocSeries(const std::string& name, const RocHistogram& scores) {
  Series series{name, {}, {}};
  for (const OperatingPoint& point : scores.Curve(kPoints)) {
    series.x.push_back(point.false_positive_rate);
    series.y.push_back(point.recall);
  }
  return series;
}

Figure RocFigure(const std::vector<NamedScores>& all) {
  Figure figure = UnitFigure(
      "roc", "Receiver operating characteristic",
      "Share of the dynamic pixels that are called dynamic (recall) against the share of the "
      "static "
      "ones that are, as the threshold falls; all scored pixels together. Higher is better; the "
      "dotted diagonal is guessing.",
      "false-positive rate", "recall");
  figure.diagonal = true;
  for (const NamedScores& one : all) {
    AddSeries(RocSeries(one.name, one.scores->pooled()), figure);
  }
  return figure;
}

Figure PrecisionRecallFigure(const std::vector<NamedScores>& all) {
  Figure figure = UnitFigure(
      "precision_recall", "Precision and recall",
      "Share of the pixels called dynamic that are (precision) against the share of the dynamic "
      "pixels that are found (recall); all scored pixels together. Higher is better.",
      "recall", "precision");
  for (const NamedScores& one : all) {
    Series series{one.name, {}, {}};
    for (const OperatingPoint& point : one.scores->pooled().Curve(kPoints)) {
      series.x.push_back(point.recall);
      series.y.push_back(point.precision);
    }
    AddSeries(std::move(series), figure);
  }
  return figure;
}

Figure ReliabilityFigure(const std::vector<NamedScores>& all) {
  Figure figure = UnitFigure(
      "reliability", "Reliability of the probabilities",
      "Of the pixels whose stated probability falls into a bin, the share that is dynamic, against "
      "the mean stated probability. On the dotted diagonal probabilities mean what they say; below "
      "it they are too high.",
      "stated probability", "share that is dynamic");
  figure.diagonal = true;
  for (const NamedScores& one : all) {
    if (!one.probabilistic) continue;
    const std::optional<Calibration> calibration = CalibrationOf(one.scores->pooled());
    if (!calibration) continue;
    Series series{one.name, {}, {}};
    for (const ReliabilityBin& bin : calibration->bins) {
      if (bin.pixels == 0) continue;
      series.x.push_back(bin.mean_stated);
      series.y.push_back(bin.positive_share);
    }
    AddSeries(std::move(series), figure);
  }
  return figure;
}

Figure SparsificationFigure(const std::vector<NamedScores>& all) {
  Figure figure{"sparsification", "Does the deviation know where the map is wrong?",
                "Mean error of the pixels that remain when those with the largest deviation are "
                "taken away, as a share of the mean error of all; dashed, when those with the "
                "largest error are. The nearer to the dashed line, the better; flat is guessing.",
                "share taken away", "remaining error"};
  figure.x_range = kUnit;
  for (const NamedScores& one : all) {
    if (!one.scores->has_deviation()) continue;
    Series ranked{one.name, {}, {}}, oracle{one.name + ", by error", {}, {}};
    oracle.style = Series::Style::kDashed;
    for (const SparsificationPoint& point : one.scores->uncertainty().Curve(50)) {
      ranked.x.push_back(point.removed);
      ranked.y.push_back(point.remaining);
      oracle.x.push_back(point.removed);
      oracle.y.push_back(point.oracle);
    }
    AddSeries(std::move(ranked), figure);
    AddSeries(std::move(oracle), figure);
  }
  return figure;
}

Figure IouByThresholdFigure(const std::vector<NamedScores>& all) {
  Figure figure =
      UnitFigure("iou_by_threshold", "IoU by threshold",
                 "Mean over the frames with movers of the intersection over union, when "
                 "pixels from this probability on are called dynamic.",
                 "threshold", "mean IoU");
  figure.y_range.reset();
  for (const NamedScores& one : all) {
    Series series{one.name, {}, one.scores->MeanIouByThreshold()};
    for (size_t step = 0; step < series.y.size(); ++step) {
      series.x.push_back(ThresholdStep(static_cast<int>(step)));
    }
    AddSeries(std::move(series), figure);
  }
  return figure;
}

Figure AucByFrameFigure(const std::vector<NamedScores>& all) {
  Figure figure{"auc_by_frame", "AUC by frame",
                "Area under the ROC curve of each frame alone. Frames whose truth has one class "
                "have none.",
                "frame", "AUC"};
  for (const NamedScores& one : all) {
    Series series{one.name, {}, {}};
    for (const FrameScores& frame : one.scores->frames()) {
      series.x.push_back(static_cast<double>(frame.index));
      series.y.push_back(frame.auc.value_or(kNone));
    }
    AddSeries(std::move(series), figure);
  }
  return figure;
}

}  // namespace egosieve::tools
