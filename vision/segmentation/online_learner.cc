#include "vision/segmentation/online_learner.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gp/calibration/leave_one_out.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "vision/labelling/stopwatch.h"
#include "vision/segmentation/frame_calibration.h"
#include "vision/segmentation/rows.h"

namespace egosieve::vision {
namespace {

// Turns regression means, whose signs are the classes, into probabilities for agreement filters.
template <typename T>
std::vector<float> PredictionsFromMeans(const T& means) {
  std::vector<float> predictions;
  predictions.reserve(means.size());
  for (const auto mean : means) {
    predictions.push_back(static_cast<float>(0.5 * (mean + 1.0)));
  }
  return predictions;
}

constexpr double kMostZeroLabel = 0.5;    // targets must stay in [-1, 1]
constexpr double kLeastZeroLabel = 0.01;  // for models with hardly any dynamic label

// (T1), as labels whose targets 2 p - 1 are y.
std::vector<double> Scaled(std::vector<double> labels, double zero_label) {
  if (zero_label == 0.5) return labels;
  for (double& label : labels) label = 0.5 + 0.5 * (label - zero_label) / (1.0 - zero_label);
  return labels;
}

// Random order of points of equal age: the order of dropping must not follow their order in the
// image.
std::vector<double> RandomRanks(size_t count, uint64_t seed, int64_t frame_index) {
  std::mt19937_64 random(seed ^ (static_cast<uint64_t>(frame_index) << 32));
  std::vector<double> ranks(count);
  for (double& rank : ranks) {
    rank = static_cast<double>(random() >> 11);
  }
  return ranks;
}

}  // namespace

void OnlineLearnerOptions::SetDensity(double radius) {
  new_point_radius = radius;
  model_radius = 0.7 * radius;
}

int64_t OnlineLearnerOptions::ArrivalLimit(int64_t size) const {
  return std::max<int64_t>(std::llround(arrival_share * static_cast<double>(budget.budget)),
                           budget.budget - size);
}

absl::Status OnlineLearnerOptions::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(model.sparse.Validate());
  EGOSIEVE_RETURN_IF_ERROR(training.Validate());
  const char* const not_negative = "not be negative";
  return kernels::CheckOptions({
      {"budget", budget.budget, budget.budget >= 0, not_negative},
      {"rare_class_share", budget.rare_class_share,
       budget.rare_class_share >= 0.0 && budget.rare_class_share <= 0.5, "be in [0, 0.5]"},
      {"maximum_age", budget.maximum_age, budget.maximum_age >= 0, not_negative},
      {"maximum_positive_age", budget.maximum_positive_age, budget.maximum_positive_age >= 0,
       not_negative},
      {"new_point_radius", new_point_radius, kernels::IsNotNegative(new_point_radius),
       "be finite and not negative"},
      {"model_radius", model_radius, kernels::IsNotNegative(model_radius),
       "be finite and not negative"},
      {"arrival_share", arrival_share, arrival_share > 0.0 && arrival_share <= 1.0, "be in (0, 1]"},
      {"zero_label", zero_label, zero_label > 0.0 && zero_label <= kMostZeroLabel,
       "be in (0, 0.5]"},
      {"calibration_sample_size", calibration_sample_size, calibration_sample_size >= 2,
       "be at least 2"},
  });
}

absl::StatusOr<std::unique_ptr<OnlineLearner>> OnlineLearner::Create(
    std::shared_ptr<kernels::Context> context, int64_t input_dimension,
    const OnlineLearnerOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  const auto bounds = gp::HyperparameterBounds::Default(options.covariance, input_dimension);
  const gp::Hyperparameters start =
      options.random_start
          ? gp::RandomHyperparameters(options.covariance, input_dimension, bounds, options.seed)
          : gp::DefaultHyperparameters(options.covariance, input_dimension);
  EGOSIEVE_ASSIGN_OR_RETURN(LearnerModel model,
                            LearnerModel::Create(context, start, options.model));
  gp::TrainerOptions training = options.training;
  training.seed = options.seed;
  EGOSIEVE_ASSIGN_OR_RETURN(gp::HyperparameterTrainer trainer,
                            gp::HyperparameterTrainer::Create(start, bounds, training));
  return std::unique_ptr<OnlineLearner>(
      new OnlineLearner(std::move(model), std::move(trainer), options));
}

OnlineLearner::OnlineLearner(LearnerModel model, gp::HyperparameterTrainer trainer,
                             const OnlineLearnerOptions& options)
    : options_(options),
      model_(std::move(model)),
      trainer_(std::move(trainer)),
      zero_label_(options.zero_label) {}

absl::Status OnlineLearner::Learn(kernels::ConstMatrixView<float> inputs,
                                  absl::Span<const double> labels, int64_t frame_index,
                                  FrameRecord& record) {
  record.selection.candidates = inputs.rows;
  std::vector<int64_t> taken;
  Stopwatch watch;
  EGOSIEVE_RETURN_IF_ERROR(UpdatePoints(inputs, labels, frame_index, taken, record.selection));
  if (options_.scales_to_mean_zero) EGOSIEVE_RETURN_IF_ERROR(ScaleToMeanZero());
  record.milliseconds.selection += watch.LapMilliseconds();
  EGOSIEVE_RETURN_IF_ERROR(trainer_.Train(*model_.context(), {model_.inputs(), model_.targets()}));
  if (trainer_.ShouldRebuild(model_.hyperparameters())) {
    EGOSIEVE_RETURN_IF_ERROR(model_.SetHyperparameters(trainer_.hyperparameters()));
    record.factor_rebuilt = true;
  }
  record.milliseconds.training += watch.LapMilliseconds();
  EGOSIEVE_RETURN_IF_ERROR(options_.calibrates_to_frame
                               ? CalibrateToFrame(inputs, labels, taken, frame_index)
                               : Calibrate());
  record.milliseconds.calibration += watch.LapMilliseconds();
  return absl::OkStatus();
}

absl::Status OnlineLearner::UpdatePoints(kernels::ConstMatrixView<float> inputs,
                                         absl::Span<const double> labels, int64_t frame_index,
                                         std::vector<int64_t>& selected, SelectionCounts& counts) {
  EGOSIEVE_ASSIGN_OR_RETURN(selected, SelectNewPoints(inputs, labels, counts));
  counts.added = static_cast<int64_t>(selected.size());
  LimitArrivals(labels, frame_index, selected);
  counts.dropped_by_budget = counts.added - static_cast<int64_t>(selected.size());
  Points arriving{GatherRows(inputs, selected), Gather(labels, selected)};
  std::vector<int64_t> alive;
  // Predictions of untrained hyperparameters are no reason to drop a point.
  if (options_.consistency_filter && trainer_.state().rounds > 0) {
    EGOSIEVE_RETURN_IF_ERROR(Add(arriving, frame_index));
    arriving = Points();
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<double> means, model_.PredictOwnMean());
    alive = FilterByAgreement(LabelsOf(model_.targets()), PredictionsFromMeans(means), true);
    counts.dropped_by_consistency = model_.size() - static_cast<int64_t>(alive.size());
  } else {
    alive.resize(model_.size());
    std::iota(alive.begin(), alive.end(), 0);
  }
  Thin(frame_index, alive, arriving, counts);
  EGOSIEVE_RETURN_IF_ERROR(model_.Remove(Complement(model_.size(), alive)));
  return Add(arriving, frame_index);
}

void OnlineLearner::LimitArrivals(absl::Span<const double> labels, int64_t frame_index,
                                  std::vector<int64_t>& selected) const {
  const int64_t limit = options_.ArrivalLimit(model_.size());
  if (static_cast<int64_t>(selected.size()) <= limit) return;
  std::vector<double> targets;
  targets.reserve(selected.size());
  for (const int64_t row : selected) targets.push_back(2.0 * labels[row] - 1.0);
  selected = Gather<int64_t>(
      selected, gp::StratifiedSample(targets, limit, options_.budget.rare_class_share,
                                     options_.seed + static_cast<uint64_t>(frame_index)));
}

absl::Status OnlineLearner::Add(const Points& points, int64_t frame_index) {
  return model_.Add(kernels::ConstMatrixView<float>(points.inputs.data(), points.size(),
                                                    model_.input_dimension()),
                    Scaled(points.labels, zero_label_), frame_index);
}

absl::Status OnlineLearner::ScaleToMeanZero() {
  if (model_.size() == 0) return absl::OkStatus();
  const std::vector<double> labels = LabelsOf(model_.targets());
  const double sum = std::accumulate(labels.begin(), labels.end(), 0.0);
  const double mean =
      std::clamp(sum / static_cast<double>(labels.size()), kLeastZeroLabel, kMostZeroLabel);
  if (mean == zero_label_) return absl::OkStatus();
  EGOSIEVE_RETURN_IF_ERROR(model_.SetLabels(Scaled(labels, mean)));
  zero_label_ = mean;
  return absl::OkStatus();
}

std::vector<double> OnlineLearner::LabelsOf(absl::Span<const double> targets) const {
  std::vector<double> labels;
  labels.reserve(targets.size());
  for (const double target : targets) {
    labels.push_back(std::clamp(zero_label_ + (1.0 - zero_label_) * target, 0.0, 1.0));
  }
  return labels;
}

absl::StatusOr<std::vector<int64_t>> OnlineLearner::SelectNewPoints(
    kernels::ConstMatrixView<float> inputs, absl::Span<const double> labels,
    SelectionCounts& counts) const {
  const std::vector<double> wide = gp::Widen(inputs);
  std::vector<int64_t> selected =
      FilterByDensity({wide.data(), inputs.rows, inputs.cols}, labels, options_.new_point_radius);
  counts.dropped_by_density = inputs.rows - static_cast<int64_t>(selected.size());
  if (!options_.novelty_filter || model_.size() == 0) {
    return selected;
  }
  const std::vector<float> candidates = GatherRows(inputs, selected);
  EGOSIEVE_ASSIGN_OR_RETURN(
      const std::vector<float> means,
      model_.PredictMean(kernels::ConstMatrixView<float>(
          candidates.data(), static_cast<int64_t>(selected.size()), inputs.cols)));
  const std::vector<int64_t> novel =
      FilterByAgreement(Gather(labels, selected), PredictionsFromMeans(means), false);
  counts.dropped_by_novelty = static_cast<int64_t>(selected.size() - novel.size());
  return Gather<int64_t>(selected, novel);
}

void OnlineLearner::Thin(int64_t frame_index, std::vector<int64_t>& alive, Points& arriving,
                         SelectionCounts& counts) const {
  // The model's kept points, then the new ones: from the oldest to the newest.
  const int64_t dimension = model_.input_dimension();
  const int64_t alive_count = static_cast<int64_t>(alive.size());
  std::vector<double> inputs = GatherRows(model_.inputs(), alive);
  inputs.insert(inputs.end(), arriving.inputs.begin(), arriving.inputs.end());
  std::vector<double> labels = LabelsOf(Gather(model_.targets(), alive));
  labels.insert(labels.end(), arriving.labels.begin(), arriving.labels.end());
  const int64_t total = static_cast<int64_t>(labels.size());

  std::vector<int64_t> newest_first(total);
  std::iota(newest_first.rbegin(), newest_first.rend(), 0);
  const std::vector<int64_t> kept = FilterByDensity({inputs.data(), total, dimension}, labels,
                                                    options_.model_radius, newest_first);
  counts.dropped_by_model_density = total - static_cast<int64_t>(kept.size());

  std::vector<int64_t> birth_frames;
  birth_frames.reserve(kept.size());
  for (const int64_t row : kept) {
    birth_frames.push_back(row < alive_count ? model_.birth_frames()[alive[row]] : frame_index);
  }
  const BudgetDecision decision =
      EnforceBudget(Gather(labels, kept), birth_frames, frame_index, options_.budget,
                    RandomRanks(kept.size(), options_.seed, frame_index));
  counts.dropped_by_age = decision.dropped_for_age;
  counts.dropped_by_budget += decision.dropped_for_budget;

  std::vector<int64_t> alive_kept, arriving_kept;
  for (const int64_t index : Complement(static_cast<int64_t>(kept.size()), decision.dropped)) {
    const int64_t row = kept[index];
    if (row < alive_count) {
      alive_kept.push_back(alive[row]);
    } else {
      arriving_kept.push_back(row - alive_count);
    }
  }
  alive = std::move(alive_kept);
  arriving = Points{GatherRows(kernels::ConstMatrixView<float>(arriving.inputs.data(),
                                                               arriving.size(), dimension),
                               arriving_kept),
                    Gather(arriving.labels, arriving_kept)};
}

absl::Status OnlineLearner::Calibrate() {
  if (model_.size() < 2) return absl::OkStatus();
  const std::vector<int64_t> sample =
      gp::StratifiedSample(model_.targets(), options_.calibration_sample_size,
                           options_.training.minimum_class_share, options_.seed);
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::LeaveOneOut predictions, model_.PredictLeaveOneOut(sample));
  const std::vector<double> labels = LabelsOf(Gather(model_.targets(), predictions.rows));
  const double noise_variance = model_.hyperparameters().noise_variance();
  EGOSIEVE_ASSIGN_OR_RETURN(
      squash_,
      gp::FitSquash(predictions.mean, predictions.LatentVariance(noise_variance), labels, squash_));
  return absl::OkStatus();
}

absl::Status OnlineLearner::CalibrateToFrame(kernels::ConstMatrixView<float> inputs,
                                             absl::Span<const double> labels,
                                             absl::Span<const int64_t> taken, int64_t frame_index) {
  constexpr int64_t kFewestLeft = 100;
  std::vector<int64_t> sorted(taken.begin(), taken.end());
  std::sort(sorted.begin(), sorted.end());
  const std::vector<int64_t> left = Complement(inputs.rows, sorted);
  if (model_.size() < 2) return absl::OkStatus();
  if (static_cast<int64_t>(left.size()) < kFewestLeft) return Calibrate();
  EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const gp::Posterior> posterior,
                            model_.MakePosterior(squash_));
  EGOSIEVE_ASSIGN_OR_RETURN(
      squash_, FitSquashToFrame(*posterior, inputs, labels, left, options_.calibration_sample_size,
                                options_.seed + static_cast<uint64_t>(frame_index)));
  return absl::OkStatus();
}

void OnlineLearner::Describe(FrameRecord& record) const {
  record.model_size = model_.size();
  record.theta = gp::ToLogarithms(model_.hyperparameters());
  record.log_likelihood_per_point =
      model_.LogMarginalLikelihood() / static_cast<double>(std::max<int64_t>(1, model_.size()));
  record.jitter = model_.jitter();
  record.squash_a = squash_.a;
  record.squash_b = squash_.b;
}

absl::StatusOr<std::shared_ptr<const gp::Posterior>> OnlineLearner::MakePosterior() const {
  return model_.MakePosterior(squash_);
}

absl::StatusOr<gp::ModelFile> OnlineLearner::Checkpoint() {
  EGOSIEVE_RETURN_IF_ERROR(model_.Rebuild());
  std::string annotations(reinterpret_cast<const char*>(&zero_label_), annotation_bytes());
  return gp::ModelFile{model_.State(), squash_, trainer_.state(), std::move(annotations)};
}

int64_t OnlineLearner::annotation_bytes() const {
  return options_.scales_to_mean_zero ? sizeof(zero_label_) : 0;
}

absl::Status OnlineLearner::Restore(const gp::ModelFile& checkpoint) {
  if (!checkpoint.trainer.has_value()) {
    return absl::InvalidArgumentError("the checkpoint holds a model without its trainer's state");
  }
  const auto& covariance = checkpoint.model.hyperparameters.covariance;
  if (covariance.function != options_.covariance ||
      covariance.input_dimension() != model_.input_dimension()) {
    return absl::InvalidArgumentError(
        "the checkpoint's covariance is not the one that was asked for");
  }
  double zero_label = options_.zero_label;
  const auto size = static_cast<size_t>(annotation_bytes());
  const bool whole = checkpoint.annotations.size() >= size;
  if (whole) std::memcpy(&zero_label, checkpoint.annotations.data(), size);
  if (!(whole && zero_label > 0.0 && zero_label <= kMostZeroLabel)) {
    return absl::InvalidArgumentError("the checkpoint holds no label for the target zero");
  }
  // The trainer checks before it changes; the model's check of its state is the expensive one.
  gp::HyperparameterTrainer trainer = trainer_;
  EGOSIEVE_RETURN_IF_ERROR(trainer.Restore(*checkpoint.trainer));
  EGOSIEVE_RETURN_IF_ERROR(model_.Restore(checkpoint.model));
  trainer_ = std::move(trainer);
  squash_ = checkpoint.squash;
  zero_label_ = zero_label;
  return absl::OkStatus();
}

}  // namespace egosieve::vision
