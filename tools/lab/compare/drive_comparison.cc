#include "tools/lab/compare/drive_comparison.h"

#include <cmath>
#include <utility>
#include <variant>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"
#include "tools/evaluate/drive_truth.h"
#include "tools/evaluate/same_drive.h"
#include "tools/segment/camera_flags.h"
#include "tools/segment/drive_input.h"
#include "tools/segment/method_run.h"
#include "vision/frame/frame_source.h"
#include "vision/segmentation/methods/map_method.h"
#include "vision/segmentation/methods/method_segmenter.h"

namespace egosieve::tools {
namespace {

// As in run folders, so that the scores equal those of `evaluate` to the last bit.
constexpr double kDeviationFullScale = 4.0;

FrameMaps MapsOf(const vision::SegmentationMap& map, const std::vector<float>& probability) {
  const auto image = [&](const std::vector<float>& values) {
    cv::Mat1f copy(map.grid.rows(), map.grid.columns());
    std::copy(values.begin(), values.end(), copy.begin());
    return copy;
  };
  return {image(probability), map.deviation.empty() ? cv::Mat1f() : image(map.deviation), {}};
}

class Comparison {
 public:
  Comparison(const Sequence& sequence, const ComparisonOptions& options, DriveTruth truth,
             const vision::MethodSegmenter& segmenter)
      : options_(options), truth_(std::move(truth)) {
    result_.sequence = sequence;
    result_.pixels = truth_.scattered() ? "interpolated from grid" : "grid";
    const int stride = options.segmenter.stride_pixels;
    for (size_t i = 0; i < options.methods.size(); ++i) {
      result_.methods.push_back({options.methods[i],
                                 segmenter.method(static_cast<int>(i)).probabilistic(),
                                 DriveScores(options.evaluate.ScoresAtStride(stride)),
                                 {}});
    }
  }

  absl::Status Add(const vision::Frame& frame, const vision::MethodAnswers& answers) {
    ++result_.frames;
    learnt_ |= answers.labels.size() > 0;
    const bool has_truth = truth_.Has(frame.index);
    result_.frames_without_truth += !has_truth;
    result_.frames_of_prior += has_truth && !learnt_;
    result_.shared_milliseconds.push_back(answers.shared_milliseconds);
    for (size_t i = 0; i < result_.methods.size(); ++i) {
      const vision::MethodAnswer& answer = answers.answers[i];
      MethodFrame entry;
      entry.index = frame.index;
      entry.model_size = answer.record.model_size;
      entry.own_milliseconds = answer.own_milliseconds;
      if (has_truth && learnt_) EGOSIEVE_RETURN_IF_ERROR(Score(frame, answer, i, entry));
      result_.methods[i].frames.push_back(entry);
    }
    if (has_truth && !truth_.scattered()) return AddFeatures(frame, answers.labels);
    return absl::OkStatus();
  }

  DriveComparison Take() { return std::move(result_); }

 private:
  absl::Status Score(const vision::Frame& frame, const vision::MethodAnswer& answer, size_t method,
                     MethodFrame& entry) {
    int64_t outside = 0;
    const absl::StatusOr<ScoredFrame> scored =
        truth_.Compare(frame.index, answer.map.grid, MapsOf(answer.map, answer.map.probability),
                       kDeviationFullScale, &outside);
    if (absl::IsOutOfRange(scored.status())) return Misfit(frame, scored.status());
    EGOSIEVE_RETURN_IF_ERROR(scored.status());
    const bool is_void = IsVoid(*scored);
    if (!is_void) {
      DriveScores& scores = result_.methods[method].scores;
      EGOSIEVE_RETURN_IF_ERROR(scores.Add(*scored));
      entry.auc = entry.auc_without_prior = scores.frames().back().auc;
      entry.iou = scores.frames().back().iou;
      if (!answer.without_prior.empty()) {
        EGOSIEVE_ASSIGN_OR_RETURN(entry.auc_without_prior, AucWithoutPrior(frame, answer));
      }
    }
    if (method == 0) {
      result_.points_outside += outside;
      result_.frames_of_void += is_void;
      result_.frames_of_one_class += !is_void && !entry.auc;
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::optional<double>> AucWithoutPrior(const vision::Frame& frame,
                                                        const vision::MethodAnswer& answer) {
    int64_t outside = 0;
    EGOSIEVE_ASSIGN_OR_RETURN(
        const ScoredFrame scored,
        truth_.Compare(frame.index, answer.map.grid, MapsOf(answer.map, answer.without_prior),
                       kDeviationFullScale, &outside));
    DriveScores scores(options_.evaluate.ScoresAtStride(options_.segmenter.stride_pixels));
    EGOSIEVE_RETURN_IF_ERROR(scores.Add(scored));
    return scores.frames().back().auc;
  }

  // Reports how many masks differ in size from this frame; `first` is the error of its own mask.
  absl::Status Misfit(const vision::Frame& frame, const absl::Status& first) const {
    int64_t count = 0;
    for (const int64_t index : truth_.frames()) {
      count += absl::IsOutOfRange(truth_.ReadMask(index, frame.image.size()).status());
    }
    return absl::FailedPreconditionError(
        absl::StrFormat("%d of %d masks do not fit their frames, first: %s", count,
                        truth_.frames().size(), first.message()));
  }

  absl::Status AddFeatures(const vision::Frame& frame, const vision::LabelledFrame& labels) {
    if (labels.size() == 0) return absl::OkStatus();
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1b mask,
                              truth_.ReadMask(frame.index, frame.image.size()));
    const std::vector<double> places = vision::PlacesInFrame(labels);
    for (int64_t i = 0; i < labels.size(); ++i) {
      const auto x = static_cast<int>(std::lround(places[2 * i]));
      const auto y = static_cast<int>(std::lround(places[2 * i + 1]));
      if (x < 0 || y < 0 || x >= mask.cols || y >= mask.rows || mask(y, x) == kTruthVoid) continue;
      const bool moves = mask(y, x) == kTruthDynamic;
      result_.at_features.Add(ScoreOf(vision::ScoreOfDistance(labels.residual_pixels[i])), moves);
      ++result_.labels.features[moves ? 1 : 0];
      result_.labels.dynamic[moves ? 1 : 0] += labels.probability[i] >= 0.5;
    }
    return absl::OkStatus();
  }

  const ComparisonOptions& options_;
  DriveTruth truth_;
  DriveComparison result_;
  bool learnt_ = false;
};

}  // namespace

void LabelCounts::Add(const LabelCounts& other) {
  for (const int moves : {0, 1}) {
    features[moves] += other.features[moves];
    dynamic[moves] += other.dynamic[moves];
  }
}

std::optional<double> LabelCounts::Precision() const {
  return Ratio(dynamic[1], dynamic[0] + dynamic[1]);
}

std::optional<double> LabelCounts::Recall() const { return Ratio(dynamic[1], features[1]); }

absl::StatusOr<DriveComparison> CompareMethods(std::shared_ptr<kernels::Context> context,
                                               const Sequence& sequence,
                                               const ComparisonOptions& options,
                                               const std::function<bool()>& after_frame) {
  EGOSIEVE_RETURN_IF_ERROR(options.evaluate.scores.Validate());
  absl::StatusOr<std::unique_ptr<vision::FrameSource>> source =
      vision::OpenFrameSource(sequence.frames, {});
  if (!source.ok()) return AsInputError(source.status());
  TruthFrames frames{FrameNames(sequence.frames), {}};
  const int64_t expected = std::max<int64_t>((*source)->expected_frame_count(), 0);
  for (int64_t i = 0; i < expected; ++i) frames.indices.push_back(i);
  EGOSIEVE_ASSIGN_OR_RETURN(DriveTruth truth,
                            DriveTruth::Open(sequence.truth, frames, options.evaluate.match));
  const size_t truth_frames = truth.frames().size();
  EGOSIEVE_ASSIGN_OR_RETURN(const DriveInput input, OpenDriveInput(sequence.frames, 0));
  EGOSIEVE_RETURN_IF_ERROR(CheckSameDrive(sequence.name, sequence.frames,
                                          input.description.fingerprint, 0, sequence.truth));
  ComparisonOptions own = options;  // with this drive's camera
  EGOSIEVE_RETURN_IF_ERROR(
      CameraFlags().Find(input, 0, /*resumes=*/false, "", own.segmenter.labeller));
  EGOSIEVE_ASSIGN_OR_RETURN(
      std::unique_ptr<vision::MethodSegmenter> segmenter,
      vision::MethodSegmenter::Create(std::move(context), own.segmenter, own.methods));
  Comparison comparison(sequence, own, std::move(truth), *segmenter);
  vision::PipelineOptions pipeline;
  pipeline.end_frame = own.max_frames > 0 ? own.max_frames : -1;
  EGOSIEVE_RETURN_IF_ERROR(
      AnswerFrames(
          **source, *segmenter, pipeline, [] { return false; },
          [&](const vision::FrameRead& read, const vision::MethodAnswers* answers) {
            if (answers != nullptr) {
              EGOSIEVE_RETURN_IF_ERROR(comparison.Add(std::get<vision::Frame>(read), *answers));
            }
            return after_frame() ? absl::OkStatus()
                                 : absl::CancelledError("interrupted; nothing was written");
          })
          .status());
  DriveComparison result = comparison.Take();
  if (result.methods.front().scores.frames().empty()) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "no frame of %s can be scored against %s (%d frames, %d without truth, %d with the prior "
        "only; truth for %d frames, void in %d, %d points outside the image); give the truth of "
        "this drive",
        sequence.frames, sequence.truth, result.frames, result.frames_without_truth,
        result.frames_of_prior, truth_frames, result.frames_of_void, result.points_outside));
  }
  return result;
}

}  // namespace egosieve::tools
