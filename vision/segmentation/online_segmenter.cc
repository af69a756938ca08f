#include "vision/segmentation/online_segmenter.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gp/io/model_file.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/equalization.h"
#include "vision/image/image_grid.h"
#include "vision/labelling/labelled_frame.h"
#include "vision/labelling/stopwatch.h"
#include "vision/segmentation/frame_record.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {
namespace {

// Writes the fields of `record` that come from labelling, including its times.
void RecordLabels(const LabelledFrame& labels, FrameRecord& record) {
  static_cast<LabelSummary&>(record) = labels;
  record.dynamic_label_count = std::count_if(labels.probability.begin(), labels.probability.end(),
                                             [](double probability) { return probability >= 0.5; });
  for (int64_t i = 0; i < labels.size(); ++i) {
    record.decided_count[static_cast<int>(labels.decided_by[i])] += labels.probability[i] >= 0.5;
  }
  if (labels.first_index >= 0) {
    record.frame_gap = static_cast<int>(labels.second_index - labels.first_index);
  }
  record.static_label_count = labels.size() - record.dynamic_label_count;
}

// What these values were chosen on: docs/constants.md.
constexpr int64_t kDefaultBudget = 1500;
constexpr int64_t kPaperBudget = 4000;
constexpr double kDefaultDensity = 0.05;
constexpr int64_t kDynamicAgeFrames = 3;
constexpr double kLocationWeight = 0.25;
constexpr double kResidualWeight = 0.3;
constexpr int64_t kInducingPoints = 256;
constexpr int64_t kFastInducingPoints = 128;
constexpr int64_t kTrainingPoints = 400;
// Longest side of the pictures for labelling, pixels.
constexpr int kLongestSide = 1920;
constexpr int kFastLongestSide = 640;

}  // namespace

OnlineSegmenterOptions OnlineSegmenterOptions::Default() {
  OnlineSegmenterOptions options;
  options.labeller.frame_gap = 0;
  options.labeller.longest_side_pixels = kLongestSide;
  options.learner.SetDensity(kDefaultDensity);
  options.learner.budget.budget = kDefaultBudget;
  options.learner.budget.maximum_positive_age = kDynamicAgeFrames;
  options.location_prior.weight = kLocationWeight;
  options.residual_weight = kResidualWeight;
  options.learner.model.kind = ModelKind::kSparse;
  options.learner.model.sparse.inducing_points = kInducingPoints;
  options.learner.training.subset_size = kTrainingPoints;
  return options;
}

OnlineSegmenterOptions OnlineSegmenterOptions::Paper() {
  OnlineSegmenterOptions options;
  options.labeller = FrameLabellerOptions::Paper();
  options.learner.scales_to_mean_zero = true;
  options.learner.random_start = true;
  options.learner.novelty_filter = true;
  options.learner.consistency_filter = true;
  options.learner.arrival_share = 1.0;
  options.learner.calibrates_to_frame = false;
  options.learner.budget.budget = kPaperBudget;
  options.learner.model.sparse.inducing_points = kInducingPoints;
  return options;
}

OnlineSegmenterOptions OnlineSegmenterOptions::Fast() {
  OnlineSegmenterOptions options = Default();
  // Flow of small pictures drifts along tracks.
  options.labeller.frame_gap = 1;
  options.labeller.longest_side_pixels = kFastLongestSide;
  options.learner.model.sparse.inducing_points = kFastInducingPoints;
  return options;
}

void OnlineSegmenterOptions::SetSeed(uint64_t seed) {
  labeller.seed = seed;
  learner.seed = seed;
}

absl::Status OnlineSegmenterOptions::Validate() const {
  EGOSIEVE_RETURN_IF_ERROR(labeller.Validate());
  EGOSIEVE_RETURN_IF_ERROR(learner.Validate());
  const auto is_share = [](double value) { return value >= 0.0 && value <= 1.0; };
  return kernels::CheckOptions({
      {"location_prior.weight", location_prior.weight, is_share(location_prior.weight),
       "be in [0, 1]"},
      {"location_prior.memory", location_prior.memory, is_share(location_prior.memory),
       "be in [0, 1]"},
      {"ahead_frames", ahead_frames, ahead_frames >= 0 && ahead_frames <= 100, "be from 0 to 100"},
      {"residual_weight", residual_weight, is_share(residual_weight), "be in [0, 1]"},
      {"stride_pixels", stride_pixels, stride_pixels >= 1, "be at least 1"},
      {"window_pixels", window_pixels,
       window_pixels >= 1 && window_pixels % 2 == 1 && window_pixels <= kMostWindowPixels,
       "be odd, from 1 to 2001"},
  });
}

absl::StatusOr<std::unique_ptr<OnlineSegmenter>> OnlineSegmenter::Create(
    std::shared_ptr<kernels::Context> context, const OnlineSegmenterOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<FrameLabeller> labeller,
                            MakeFrameLabeller(options.labeller));
  EGOSIEVE_ASSIGN_OR_RETURN(
      std::unique_ptr<OnlineLearner> learner,
      OnlineLearner::Create(std::move(context), kBoxMeanColumns, options.learner));
  return std::unique_ptr<OnlineSegmenter>(
      new OnlineSegmenter(options, std::move(labeller), std::move(learner)));
}

OnlineSegmenter::OnlineSegmenter(const OnlineSegmenterOptions& options,
                                 std::unique_ptr<FrameLabeller> labeller,
                                 std::unique_ptr<OnlineLearner> learner)
    : options_(options),
      labeller_(std::move(labeller)),
      learner_(std::move(learner)),
      location_prior_(options.location_prior) {}

cv::Mat OnlineSegmenter::Equalized(const Frame& frame) const {
  return EqualizeLuminance(frame.image, options_.labeller.equalization);
}

absl::StatusOr<OnlineSegmenter::Learnt> OnlineSegmenter::Learn(
    const Frame& frame, std::shared_ptr<const ExtractedFrame> extracted, bool with_posterior,
    const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead) {
  EGOSIEVE_ASSIGN_OR_RETURN(LabelledFrame labels, labeller_->Label(std::move(extracted), ahead));
  return LearnLabels(frame, std::move(labels), with_posterior);
}

absl::StatusOr<OnlineSegmenter::Learnt> OnlineSegmenter::LearnLabels(const Frame& frame,
                                                                     LabelledFrame labelled,
                                                                     bool with_posterior) {
  Learnt learnt;
  FrameRecord& record = learnt.record;
  learnt.labels = std::move(labelled);
  const LabelledFrame& labels = learnt.labels;
  RecordLabels(labels, record);
  record.time_seconds = frame.time_seconds;
  if (labels.size() > 0) {
    Stopwatch watch;
    const cv::Mat picture = Equalized(labels.labelled);
    EGOSIEVE_ASSIGN_OR_RETURN(
        const std::vector<float> inputs,
        BoxMeansAt(ViewOf(picture), labels.positions_view(), options_.window_pixels));
    record.milliseconds.selection += watch.LapMilliseconds();
    process_.reset();
    residual_ = LabelResidual();
    const kernels::ConstMatrixView<float> places(inputs.data(), labels.size(), kBoxMeanColumns);
    const absl::Status status = learner_->Learn(places, labels.probability, frame.index, record);
    // What the data cause, such as a matrix that is not positive definite, costs the frame alone;
    // what the computer or its driver causes ends the run.
    if (!status.ok() && !absl::IsFailedPrecondition(status) && !absl::IsInvalidArgument(status)) {
      return status;
    }
    location_prior_.Learn(labels);
    if (status.ok() && options_.residual_weight > 0.0 && labels.labelled.index == frame.index) {
      watch.LapMilliseconds();
      EGOSIEVE_RETURN_IF_ERROR(TakeResidual(labels, places));
      record.milliseconds.posterior += watch.LapMilliseconds();
    }
    record.learnt = status.ok();
    if (!status.ok()) {
      record.reason = absl::StrFormat("the model could not learn: %s", status.message());
    }
  }
  learner_->Describe(record);
  if (with_posterior) {
    Stopwatch watch;
    if (process_ == nullptr) {
      EGOSIEVE_ASSIGN_OR_RETURN(process_, learner_->MakePosterior());
    }
    learnt.posterior = MapPosterior{process_, location_prior_, residual_};
    record.milliseconds.posterior += watch.LapMilliseconds();
  }
  return learnt;
}

absl::Status OnlineSegmenter::TakeResidual(const LabelledFrame& labels,
                                           kernels::ConstMatrixView<float> places) {
  EGOSIEVE_ASSIGN_OR_RETURN(process_, learner_->MakePosterior());
  std::vector<float> own(labels.size());
  kernels::PosteriorOutputs outputs;
  outputs.probability = own.data();
  EGOSIEVE_RETURN_IF_ERROR(process_->Evaluate(places, outputs).status());
  residual_ = LabelResidual(labels.labelled.index, labels.labelled.image.size(),
                            labels.positions_view(), labels.probability, own);
  return absl::OkStatus();
}

absl::StatusOr<SegmentationMap> OnlineSegmenter::Infer(const Frame& frame,
                                                       const MapPosterior& posterior,
                                                       FrameRecord& record) const {
  Stopwatch watch;
  SegmentationMap map;
  map.frame_index = frame.index;
  map.grid = ImageGrid{frame.image.cols, frame.image.rows, options_.stride_pixels};
  const cv::Mat picture = Equalized(frame);
  const std::vector<float> field =
      BoxMeansOnGrid(ViewOf(picture), map.grid, options_.window_pixels);
  const int64_t size = map.grid.size();
  map.probability.resize(size);
  map.mean.resize(size);
  map.deviation.resize(size);
  kernels::PosteriorOutputs outputs;
  outputs.mean = map.mean.data();
  outputs.variance = map.deviation.data();
  outputs.probability = map.probability.data();
  EGOSIEVE_ASSIGN_OR_RETURN(
      const kernels::PosteriorCounts counts,
      posterior.process->Evaluate(
          kernels::ConstMatrixView<float>(field.data(), size, kBoxMeanColumns), outputs));
  for (float& value : map.deviation) {
    value = std::sqrt(value);
  }
  posterior.residual.Apply(options_.residual_weight, map);
  posterior.location.Apply(map);
  record.clamped_variances = counts.clamped_variances;
  const int64_t dynamic = std::count_if(map.probability.begin(), map.probability.end(),
                                        [](float probability) { return probability >= 0.5f; });
  record.dynamic_share = static_cast<double>(dynamic) / static_cast<double>(size);
  record.expected_overlap = ExpectedOverlap(map.probability);
  record.milliseconds.inference += watch.LapMilliseconds();
  return map;
}

absl::StatusOr<std::string> OnlineSegmenter::Checkpoint(absl::string_view labeller_state) {
  EGOSIEVE_ASSIGN_OR_RETURN(gp::ModelFile checkpoint, learner_->Checkpoint());
  checkpoint.annotations += location_prior_.ToBytes();
  absl::StrAppend(&checkpoint.annotations, labeller_state);
  process_.reset();  // it was made from the factor before rebuilding
  return gp::SerializeModel(checkpoint);
}

absl::Status OnlineSegmenter::Restore(absl::string_view checkpoint,
                                      const std::vector<Frame>& recent) {
  EGOSIEVE_ASSIGN_OR_RETURN(const gp::ModelFile file,
                            gp::ParseModel({checkpoint.data(), checkpoint.size()}));
  EGOSIEVE_RETURN_IF_ERROR(learner_->Restore(file));
  process_.reset();
  residual_ = LabelResidual();
  absl::string_view rest = file.annotations;
  rest.remove_prefix(learner_->annotation_bytes());
  const size_t prior = std::min(location_prior_.ToBytes().size(), rest.size());
  EGOSIEVE_RETURN_IF_ERROR(location_prior_.Restore({rest.data(), prior}));
  rest.remove_prefix(prior);
  EGOSIEVE_RETURN_IF_ERROR(labeller_->Restore(rest));
  for (const Frame& frame : recent) {
    EGOSIEVE_RETURN_IF_ERROR(labeller_->Prime(frame));
  }
  return absl::OkStatus();
}

}  // namespace egosieve::vision
