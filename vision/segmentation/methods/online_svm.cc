#include "vision/segmentation/methods/online_svm.h"

#include <algorithm>
#include <numeric>
#include <random>

#include "gp/calibration/leave_one_out.h"
#include "gp/selection/agreement_filter.h"
#include "gp/selection/density_filter.h"
#include "kernels/base/status_macros.h"
#include "vision/segmentation/rows.h"
#include "vision/segmentation/stage_timer.h"

namespace egosieve::vision {
namespace {

std::vector<double> Targets(const std::vector<double>& labels) {
  std::vector<double> targets;
  for (const double label : labels) targets.push_back(2.0 * label - 1.0);
  return targets;
}

std::vector<uint8_t> Classes(const std::vector<double>& labels) {
  std::vector<uint8_t> positive;
  for (const double label : labels) positive.push_back(label >= 0.5 ? 1 : 0);
  return positive;
}

}  // namespace

kernels::ConstMatrixView<float> OnlineSvm::View() const {
  return {inputs_.data(), size(), dimension_};
}

void OnlineSvm::Append(kernels::ConstMatrixView<float> inputs, absl::Span<const double> labels,
                       absl::Span<const int64_t> rows, int64_t frame_index) {
  const std::vector<float> arriving = GatherRows(inputs, rows);
  inputs_.insert(inputs_.end(), arriving.begin(), arriving.end());
  for (const int64_t row : rows) labels_.push_back(labels[row]);
  births_.insert(births_.end(), rows.size(), frame_index);
}

void OnlineSvm::Keep(absl::Span<const int64_t> rows) {
  inputs_ = GatherRows(View(), rows);
  labels_ = Gather<double>(labels_, rows);
  births_ = Gather<int64_t>(births_, rows);
}

std::vector<float> OnlineSvm::Predictions(kernels::ConstMatrixView<float> points) const {
  std::vector<float> predictions(points.rows, 0.5f);
  if (!machine_) return predictions;
  const std::vector<double> decisions = machine_->Decide(points);
  for (size_t i = 0; i < decisions.size(); ++i) predictions[i] = decisions[i] > 0.0 ? 1.0f : 0.0f;
  return predictions;
}

absl::StatusOr<std::vector<int64_t>> OnlineSvm::SelectNew(kernels::ConstMatrixView<float> inputs,
                                                          absl::Span<const double> labels,
                                                          int64_t frame_index,
                                                          SelectionCounts& counts) const {
  const OnlineLearnerOptions& learner = options_.learner;
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<int64_t> rows,
                            gp::FilterByDensity(inputs, labels, learner.new_point_density));
  counts.dropped_by_density = inputs.rows - static_cast<int64_t>(rows.size());
  if (learner.novelty_filter && machine_) {
    const std::vector<float> points = GatherRows(inputs, rows);
    EGOSIEVE_ASSIGN_OR_RETURN(
        const std::vector<int64_t> novel,
        gp::FilterByNovelty(
            Gather<double>(labels, rows),
            Predictions({points.data(), static_cast<int64_t>(rows.size()), inputs.cols})));
    counts.dropped_by_novelty = static_cast<int64_t>(rows.size() - novel.size());
    rows = Gather<int64_t>(rows, novel);
  }
  counts.added = static_cast<int64_t>(rows.size());
  const int64_t limit = learner.ArrivalLimit(size());
  if (static_cast<int64_t>(rows.size()) > limit) {
    const std::vector<int64_t> sampled = gp::StratifiedSample(
        Targets(Gather<double>(labels, rows)), limit, learner.budget.rare_class_share,
        learner.seed + static_cast<uint64_t>(frame_index));
    rows = Gather<int64_t>(rows, sampled);
  }
  counts.dropped_by_budget = counts.added - static_cast<int64_t>(rows.size());
  return rows;
}

absl::Status OnlineSvm::Thin(int64_t frame_index, SelectionCounts& counts) {
  const OnlineLearnerOptions& learner = options_.learner;
  std::vector<int64_t> newest_first(size());
  std::iota(newest_first.rbegin(), newest_first.rend(), 0);
  EGOSIEVE_ASSIGN_OR_RETURN(
      const std::vector<int64_t> kept,
      gp::FilterByDensity(View(), labels_, learner.model_density, newest_first));
  counts.dropped_by_model_density = size() - static_cast<int64_t>(kept.size());
  Keep(kept);
  std::mt19937_64 random(learner.seed ^ (static_cast<uint64_t>(frame_index) << 32));
  std::vector<double> ranks(size());
  for (double& rank : ranks) rank = static_cast<double>(random() >> 11);
  EGOSIEVE_ASSIGN_OR_RETURN(
      const gp::BudgetDecision decision,
      gp::EnforceBudget(labels_, births_, frame_index, learner.budget, ranks));
  counts.dropped_by_age = decision.dropped_for_age;
  counts.dropped_by_budget += decision.dropped_for_budget;
  std::vector<int64_t> stay;
  for (int64_t row = 0; row < size(); ++row) {
    if (!std::binary_search(decision.dropped.begin(), decision.dropped.end(), row)) {
      stay.push_back(row);
    }
  }
  Keep(stay);
  return absl::OkStatus();
}

std::vector<int64_t> OnlineSvm::Sample(int64_t count) const {
  return gp::StratifiedSample(Targets(labels_), count,
                              options_.learner.training.minimum_class_share, options_.learner.seed);
}

absl::Status OnlineSvm::Train() {
  const std::vector<int64_t> rows = Sample(options_.training_points);
  const std::vector<float> inputs = GatherRows(View(), rows);
  const std::vector<uint8_t> classes = Classes(Gather<double>(labels_, rows));
  const auto positives = std::count(classes.begin(), classes.end(), 1);
  if (positives == 0 || positives == static_cast<int64_t>(classes.size())) {
    machine_.reset();
    return absl::OkStatus();
  }
  if (trainings_++ % options_.parameter_interval == 0) {
    const std::vector<int64_t> few = Sample(options_.learner.training.annealing_subset_size);
    const std::vector<float> points = GatherRows(View(), few);
    EGOSIEVE_ASSIGN_OR_RETURN(
        parameters_,
        ChooseSvmParameters({points.data(), static_cast<int64_t>(few.size()), dimension_},
                            Classes(Gather<double>(labels_, few)), options_.folds));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(
      machine_, SvmClassifier::Train({inputs.data(), static_cast<int64_t>(rows.size()), dimension_},
                                     classes, parameters_));
  return absl::OkStatus();
}

absl::Status OnlineSvm::Calibrate() {
  const std::vector<int64_t> rows = Sample(options_.learner.calibration_sample_size);
  const std::vector<float> inputs = GatherRows(View(), rows);
  const std::vector<uint8_t> classes = Classes(Gather<double>(labels_, rows));
  std::vector<double> decisions(rows.size(), 0.0);
  if (machine_) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        decisions,
        CrossValidatedDecisions({inputs.data(), static_cast<int64_t>(rows.size()), dimension_},
                                classes, parameters_, options_.folds));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(sigmoid_, FitPlattSigmoid(decisions, classes));
  return absl::OkStatus();
}

absl::Status OnlineSvm::Learn(kernels::ConstMatrixView<float> inputs,
                              absl::Span<const double> labels, int64_t frame_index,
                              FrameRecord& record) {
  dimension_ = inputs.cols;
  record.selection.candidates = inputs.rows;
  {
    StageTimer timer(record.milliseconds.selection);
    EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> rows,
                              SelectNew(inputs, labels, frame_index, record.selection));
    Append(inputs, labels, rows, frame_index);
    // As for the process, the first frame's points are not filtered: a machine would have seen only
    // them.
    if (options_.learner.consistency_filter && machine_) {
      EGOSIEVE_RETURN_IF_ERROR(Train());  // "after their incorporation"
      if (machine_) {
        EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<int64_t> consistent,
                                  gp::FilterByConsistency(labels_, Predictions(View())));
        record.selection.dropped_by_consistency = size() - static_cast<int64_t>(consistent.size());
        Keep(consistent);
      }
    }
    EGOSIEVE_RETURN_IF_ERROR(Thin(frame_index, record.selection));
  }
  {
    StageTimer timer(record.milliseconds.training);
    EGOSIEVE_RETURN_IF_ERROR(Train());
  }
  StageTimer timer(record.milliseconds.calibration);
  return Calibrate();
}

std::vector<float> OnlineSvm::Probability(kernels::ConstMatrixView<float> queries) const {
  std::vector<float> probability(queries.rows, static_cast<float>(sigmoid_.Probability(0.0)));
  if (!machine_) return probability;
  const std::vector<double> decisions = machine_->Decide(queries);
  for (size_t i = 0; i < decisions.size(); ++i) {
    probability[i] = static_cast<float>(sigmoid_.Probability(decisions[i]));
  }
  return probability;
}

}  // namespace egosieve::vision
