#include "tools/evaluation/drive_scores.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluation/boundary.h"
#include "tools/evaluation/calibration.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint8_t kVoid = 128;

Json ConfusionJson(const RocHistogram& scores, int threshold) {
  const Confusion c = scores.At(threshold);
  return {{"threshold", threshold / 65535.0},
          {"iou", OrNull(c.Iou())},
          {"f", OrNull(c.F())},
          {"precision", OrNull(c.Precision())},
          {"recall", OrNull(c.Recall())},
          {"false_positive_rate", OrNull(c.FalsePositiveRate())}};
}

// 2 sqrt(p (1 - p)) of a 16-bit probability, as 16 bits.
uint16_t ClassDeviation(uint16_t score) {
  const double p = score / 65535.0;
  return ScoreOf(2.0 * std::sqrt(p * (1.0 - p)));
}

Json CalibrationJson(const RocHistogram& scores, int bins) {
  const std::optional<Calibration> calibration = CalibrationOf(scores, bins);
  if (!calibration) return Json();
  Json reliability = Json::array();
  for (const ReliabilityBin& bin : calibration->bins) {
    reliability.push_back({{"low", bin.low},
                           {"high", bin.high},
                           {"pixels", bin.pixels},
                           {"mean_stated", bin.mean_stated},
                           {"positive_share", bin.positive_share}});
  }
  return {{"log_loss", calibration->log_loss},
          {"brier", calibration->brier},
          {"expected_calibration_error", calibration->expected_calibration_error},
          {"reliability", reliability}};
}

Json CurveJson(const RocHistogram& scores, int points) {
  Json curve = Json::array();
  for (const OperatingPoint& p : scores.Curve(points)) {
    curve.push_back({p.threshold / 65535.0, p.false_positive_rate, p.recall, p.precision});
  }
  return curve;
}

void AppendFigure(const char* name, const std::optional<double>& value, std::string* text) {
  if (value) absl::StrAppendFormat(text, "%s %.4f\n", name, *value);
}

}  // namespace

absl::Status DriveScoresOptions::Validate() const {
  if (!(threshold >= 0.0 && threshold <= 1.0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("threshold = %g; it must be from 0 to 1", threshold));
  }
  if (calibration_bins < 1 || curve_points < 2) {
    return absl::InvalidArgumentError(
        absl::StrFormat("calibration_bins = %d, curve_points = %d; they must be at least 1 and 2",
                        calibration_bins, curve_points));
  }
  return objects.Validate();
}

DriveScores::DriveScores(const DriveScoresOptions& options)
    : options_(options),
      uncertainty_(ThresholdOf(options.threshold)),
      class_uncertainty_(ThresholdOf(options.threshold)) {}

absl::Status DriveScores::Add(const ScoredFrame& frame) {
  const cv::Size size = frame.probability.size();
  if (frame.truth.size() != size || (!frame.deviation.empty() && frame.deviation.size() != size)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("frame %d: a map of %d x %d pixels and a truth of %d x %d", frame.index,
                        size.width, size.height, frame.truth.cols, frame.truth.rows));
  }
  std::optional<ObjectScores> objects;
  std::optional<double> boundary_f;
  if (!frame.scattered) {
    EGOSIEVE_ASSIGN_OR_RETURN(const Regions regions, ScoreRegions(frame));
    objects = regions.objects;
    boundary_f = regions.boundary_f;
  }
  RocHistogram own;
  FrameScores scores;
  scores.index = frame.index;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (frame.truth(y, x) == kVoid) {
        ++scores.void_pixels;
        continue;
      }
      const bool positive = frame.truth(y, x) != 0;
      own.Add(frame.probability(y, x), positive);
      class_uncertainty_.Add(frame.probability(y, x), ClassDeviation(frame.probability(y, x)),
                             positive);
      if (!frame.deviation.empty())
        uncertainty_.Add(frame.probability(y, x), frame.deviation(y, x), positive);
    }
  }
  has_deviation_ |= !frame.deviation.empty();
  FillFrameScores(own, boundary_f, scores);
  frames_.push_back(scores);
  pooled_.Merge(own);
  if (objects) objects_.Add(*objects, frame.objects);
  return absl::OkStatus();
}

absl::StatusOr<DriveScores::Regions> DriveScores::ScoreRegions(const ScoredFrame& frame) const {
  const cv::Mat1b void_pixels = frame.truth == kVoid;
  const cv::Mat1b dynamic = (frame.truth != 0) & ~void_pixels;
  const cv::Mat1b called = (frame.probability >= ThresholdOf(options_.threshold)) & ~void_pixels;
  const cv::Mat1i ids = frame.ids.empty() ? ComponentsOf(dynamic) : frame.ids;
  const vision::ObjectThresholds& thresholds = options_.objects.thresholds;
  const cv::Mat1i predicted =
      vision::NumberObjects((frame.probability >= ThresholdOf(thresholds.low)) & ~void_pixels,
                            (frame.probability >= ThresholdOf(thresholds.high)) & ~void_pixels);
  Regions regions;
  EGOSIEVE_ASSIGN_OR_RETURN(regions.objects,
                            ScoreObjects(predicted, ids, void_pixels, options_.objects));
  EGOSIEVE_ASSIGN_OR_RETURN(const BoundaryScore boundary, BoundaryF(called, dynamic, void_pixels));
  regions.boundary_f = boundary.f;
  return regions;
}

void DriveScores::FillFrameScores(const RocHistogram& own, std::optional<double> boundary_f,
                                  FrameScores& scores) {
  const Confusion c = own.At(ThresholdOf(options_.threshold));
  scores.dynamic_pixels = own.positive_count();
  scores.static_pixels = own.negative_count();
  scores.has_movers = scores.dynamic_pixels > 0;
  scores.auc = own.Auc();
  scores.average_precision = own.AveragePrecision();
  scores.false_positive_rate = c.FalsePositiveRate();
  if (const std::optional<Calibration> calibration =
          CalibrationOf(own, options_.calibration_bins)) {
    scores.brier = calibration->brier;
    scores.log_loss = calibration->log_loss;
  }
  if (!scores.has_movers) {
    mover_free_pixels_ += scores.static_pixels;
    mover_free_alarms_ += c.false_positives;
    return;
  }
  scores.iou = c.Iou();
  scores.f = c.F();
  scores.boundary_f = boundary_f;
  scores.best_iou = own.At(*own.BestThreshold()).Iou();
  for (int step = 0; step < kThresholdSteps; ++step) {
    scores.iou_at[step] = own.At(ThresholdOf(ThresholdStep(step))).Iou().value_or(0.0);
  }
}

void DriveScores::Merge(const DriveScores& other) {
  pooled_.Merge(other.pooled_);
  uncertainty_.Merge(other.uncertainty_);
  class_uncertainty_.Merge(other.class_uncertainty_);
  has_deviation_ |= other.has_deviation_;
  frames_.insert(frames_.end(), other.frames_.begin(), other.frames_.end());
  objects_.Merge(other.objects_);
  mover_free_pixels_ += other.mover_free_pixels_;
  mover_free_alarms_ += other.mover_free_alarms_;
}

std::optional<double> DriveScores::Mean(std::optional<double> FrameScores::*figure) const {
  double sum = 0.0;
  int64_t count = 0;
  for (const FrameScores& frame : frames_) {
    if (!(frame.*figure)) continue;
    sum += *(frame.*figure);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

std::vector<double> DriveScores::MeanIouByThreshold() const {
  std::vector<double> sums(kThresholdSteps);
  int64_t count = 0;
  for (const FrameScores& frame : frames_) {
    if (!frame.has_movers) continue;
    for (int step = 0; step < kThresholdSteps; ++step) sums[step] += frame.iou_at[step];
    ++count;
  }
  if (count == 0) return {};
  for (double& sum : sums) sum /= static_cast<double>(count);
  return sums;
}

std::optional<double> DriveScores::FalsePositiveRateWithoutMovers() const {
  if (mover_free_pixels_ == 0) return std::nullopt;
  return static_cast<double>(mover_free_alarms_) / static_cast<double>(mover_free_pixels_);
}

Json DriveScores::ToJson() const {
  const std::optional<int> best = pooled_.BestThreshold();
  Json uncertainty;
  if (has_deviation_) {
    Json curve = Json::array();
    for (const SparsificationPoint& p : uncertainty_.Curve(50))
      curve.push_back({p.removed, p.remaining, p.oracle});
    uncertainty = {
        {"area_under_sparsification_error", OrNull(uncertainty_.AreaUnderSparsificationError())},
        {"error_auc", OrNull(uncertainty_.ErrorAuc())},
        {"sparsification", curve}};
  }
  return {
      {"pooled_auc", OrNull(pooled_.Auc())},
      {"mean_auc", OrNull(Mean(&FrameScores::auc))},
      {"average_precision", OrNull(pooled_.AveragePrecision())},
      {"mean_average_precision", OrNull(Mean(&FrameScores::average_precision))},
      {"at_declared_threshold", ConfusionJson(pooled_, ThresholdOf(options_.threshold))},
      {"at_best_threshold", best ? ConfusionJson(pooled_, *best) : Json()},
      {"mean_iou", OrNull(Mean(&FrameScores::iou))},
      {"mean_f", OrNull(Mean(&FrameScores::f))},
      {"mean_best_iou", OrNull(Mean(&FrameScores::best_iou))},
      {"mean_iou_at_0.05_to_0.95", MeanIouByThreshold()},
      {"mean_boundary_f", OrNull(Mean(&FrameScores::boundary_f))},
      {"false_positive_rate_without_movers", OrNull(FalsePositiveRateWithoutMovers())},
      {"calibration", CalibrationJson(pooled_, options_.calibration_bins)},
      {"uncertainty", uncertainty},
      {"class_uncertainty",
       {{"area_under_sparsification_error",
         OrNull(class_uncertainty_.AreaUnderSparsificationError())},
        {"error_auc", OrNull(class_uncertainty_.ErrorAuc())}}},
      {"object_thresholds", {options_.objects.thresholds.low, options_.objects.thresholds.high}},
      {"false_objects_per_frame", OrNull(objects_.FalseObjectsPerFrame())},
      {"object_recall", objects_.RecallToJson()},
      {"curve_threshold_fpr_recall_precision", CurveJson(pooled_, options_.curve_points)}};
}

std::string DriveScores::Summary() const {
  std::string text;
  AppendFigure("average precision, pooled", pooled_.AveragePrecision(), &text);
  AppendFigure("average precision, mean over frames", Mean(&FrameScores::average_precision), &text);
  AppendThreshold("declared threshold", ThresholdOf(options_.threshold), &text);
  if (const std::optional<int> best = pooled_.BestThreshold())
    AppendThreshold("best threshold", *best, &text);
  AppendFigure("mean IoU over frames, declared threshold", Mean(&FrameScores::iou), &text);
  AppendFigure("mean F over frames, declared threshold", Mean(&FrameScores::f), &text);
  AppendFigure("mean IoU over frames, each frame's best threshold", Mean(&FrameScores::best_iou),
               &text);
  const std::vector<double> by_threshold = MeanIouByThreshold();
  if (!by_threshold.empty()) {
    const auto best = std::max_element(by_threshold.begin(), by_threshold.end());
    absl::StrAppendFormat(&text, "mean IoU over frames, best one threshold (%.2f): %.4f\n",
                          ThresholdStep(static_cast<int>(best - by_threshold.begin())), *best);
  }
  AppendFigure("mean boundary F, declared threshold", Mean(&FrameScores::boundary_f), &text);
  AppendFigure("false-positive rate on frames without movers", FalsePositiveRateWithoutMovers(),
               &text);
  if (const std::optional<Calibration> calibration =
          CalibrationOf(pooled_, options_.calibration_bins)) {
    absl::StrAppendFormat(&text, "calibration: ECE %.4f, Brier %.4f, log loss %.4f\n",
                          calibration->expected_calibration_error, calibration->brier,
                          calibration->log_loss);
  }
  if (has_deviation_) {
    AppendFigure("area under the sparsification error", uncertainty_.AreaUnderSparsificationError(),
                 &text);
    AppendFigure("AUC of the deviation for finding errors", uncertainty_.ErrorAuc(), &text);
  }
  AppendFigure("AUC of the class's deviation, sqrt(p (1 - p)), for finding errors",
               class_uncertainty_.ErrorAuc(), &text);
  for (const auto& [group, r] : objects_.recall()) {
    absl::StrAppendFormat(&text, "objects (from %.2f, with %.2f), %s: %d of %d found (IoU %.2f)\n",
                          options_.objects.thresholds.low, options_.objects.thresholds.high, group,
                          r.found, r.objects, options_.objects.iou_threshold);
  }
  AppendFigure("false objects per frame", objects_.FalseObjectsPerFrame(), &text);
  return text;
}

void DriveScores::AppendThreshold(const char* name, int threshold, std::string* text) const {
  const Confusion c = pooled_.At(threshold);
  if (!c.Iou()) return;
  absl::StrAppendFormat(text, "%s %.2f, pooled: IoU %.4f, F %.4f", name, threshold / 65535.0,
                        *c.Iou(), c.F().value_or(0.0));
  if (c.Precision()) absl::StrAppendFormat(text, ", precision %.4f", *c.Precision());
  if (c.Recall()) absl::StrAppendFormat(text, ", recall %.4f", *c.Recall());
  if (c.FalsePositiveRate())
    absl::StrAppendFormat(text, ", false-positive rate %.4f", *c.FalsePositiveRate());
  text->push_back('\n');
}

}  // namespace egosieve::tools
