#include "tools/evaluate/evaluate_run.h"

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluate/same_drive.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

// Masks of a wrong size are counted to the end, so that the error can give their number.
struct Misfits {
  int64_t count = 0;
  int64_t of = 0;
  std::string first;

  absl::Status status() const {
    if (count == 0) return absl::OkStatus();
    return absl::FailedPreconditionError(
        absl::StrFormat("%d of %d masks do not fit their frames, first: %s", count, of, first));
  }
};

class RunScorer {
 public:
  RunScorer(const RunFolder& folder, RunDescription description, const DriveTruth& truth,
            const EvaluateOptions& options)
      : folder_(folder),
        description_(std::move(description)),
        truth_(truth),
        options_(options),
        scores_(options.pixels == ScoredPixels::kGrid
                    ? options.ScoresAtStride(description_.grid.stride)
                    : options.scores),
        masks_(options.scores.objects) {}

  // Scores a line that has a map and a truth.
  absl::Status Score(const FrameLine& line) {
    EGOSIEVE_ASSIGN_OR_RETURN(const FrameMaps maps,
                              ReadScoredMaps(folder_, description_, line, options_.pixels));
    const kernels::ImageGrid grid = ScoredGrid(line, description_, options_.pixels);
    ++misfits_.of;
    const absl::StatusOr<ScoredFrame> frame =
        truth_.Compare(line.index, grid, maps, description_.deviation_full_scale, &points_outside_);
    if (absl::IsOutOfRange(frame.status())) {
      if (misfits_.count++ == 0) misfits_.first = std::string(frame.status().message());
      return absl::OkStatus();
    }
    EGOSIEVE_RETURN_IF_ERROR(frame.status());
    if (IsVoid(*frame)) {
      ++frames_without_points_;
      return absl::OkStatus();
    }
    return scores_.Add(*frame);
  }

  // Scores the mask of reconstruct for a line with a truth; does nothing if there is no mask.
  absl::Status ScoreMask(const FrameLine& line) {
    const std::string path = folder_.FrameFile("masks", line.index, ".png");
    if (truth_.scattered() || !std::filesystem::exists(path)) return absl::OkStatus();
    const cv::Size size(line.width_pixels, line.height_pixels);
    MaskFrame frame;
    frame.index = line.index;
    const absl::StatusOr<cv::Mat1b> truth = truth_.ReadMask(line.index, size);
    if (absl::IsOutOfRange(truth.status())) return absl::OkStatus();  // counted by Score
    EGOSIEVE_RETURN_IF_ERROR(truth.status());
    frame.truth = *truth;
    EGOSIEVE_ASSIGN_OR_RETURN(frame.mask, ReadTruthMask(path, size));
    EGOSIEVE_ASSIGN_OR_RETURN(frame.truth_ids, truth_.ReadIds(line.index, size));
    frame.objects = truth_.ObjectsOf(line.index);
    const std::string ids_path = folder_.FrameFile("ids", line.index, ".png");
    if (!frame.truth_ids.empty() && std::filesystem::exists(ids_path)) {
      EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat ids, ReadImage(ids_path, cv::IMREAD_UNCHANGED));
      if (ids.type() != CV_16UC1 || ids.size() != size) {
        return absl::DataLossError(
            absl::StrCat(ids_path, " is damaged; run egosieve reconstruct again"));
      }
      ids.convertTo(frame.ids, CV_32S);
    }
    return masks_.Add(frame);
  }

  const Misfits& misfits() const { return misfits_; }
  int64_t points_outside() const { return points_outside_; }
  int64_t frames_without_points() const { return frames_without_points_; }
  DriveScores TakeScores() { return std::move(scores_); }
  MaskScores TakeMasks() { return std::move(masks_); }

 private:
  const RunFolder& folder_;
  const RunDescription description_;
  const DriveTruth& truth_;
  const EvaluateOptions& options_;
  DriveScores scores_;
  MaskScores masks_;
  Misfits misfits_;
  int64_t points_outside_ = 0;
  int64_t frames_without_points_ = 0;
};

std::string PixelsName(const DriveTruth& truth, ScoredPixels pixels) {
  const char* name = pixels == ScoredPixels::kGrid ? "grid" : "full";
  return truth.scattered() ? absl::StrCat("interpolated from ", name) : name;
}

}  // namespace

DriveScoresOptions EvaluateOptions::ScoresAtStride(int stride) const {
  DriveScoresOptions at_grid = scores;
  at_grid.objects.min_area = std::max(1, scores.objects.min_area / (stride * stride));
  return at_grid;
}

absl::StatusOr<RunEvaluation> EvaluateRun(const RunFolder& folder, const std::string& truth_path,
                                          const EvaluateOptions& options,
                                          const std::function<bool()>& after_frame) {
  EGOSIEVE_RETURN_IF_ERROR(options.scores.Validate());
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  TruthFrames frames{FrameNames(description.input.path), {}};
  for (const FrameLine& line : lines) frames.indices.push_back(line.index);
  EGOSIEVE_ASSIGN_OR_RETURN(const DriveTruth truth,
                            DriveTruth::Open(truth_path, frames, options.match));
  int64_t from = 0;
  const auto flag = description.flags.find("from");
  if (flag != description.flags.end() && !absl::SimpleAtoi(flag->second, &from)) from = 0;
  EGOSIEVE_RETURN_IF_ERROR(CheckSameDrive(absl::StrCat("the run in ", folder.path()),
                                          description.input.path, description.input.fingerprint,
                                          from, truth_path));

  Evaluation evaluation;
  evaluation.truth = truth.path();
  evaluation.truth_kind = truth.kind();
  evaluation.matched_by = truth.matched_by();
  evaluation.pixels = PixelsName(truth, options.pixels);
  RunScorer scorer(folder, description, truth, options);
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<ScorableLine> scorable, ReadScorableLines(folder));
  int64_t matched = 0;
  for (const auto& [line, of_prior] : scorable) {  // truth of other lines counts as without a map
    if (!truth.Has(line.index)) {
      ++evaluation.frames_without_mask;
      continue;
    }
    ++matched;
    EGOSIEVE_RETURN_IF_ERROR(scorer.ScoreMask(line));
    if (of_prior && !options.with_prior) {
      ++evaluation.frames_of_prior;
    } else {
      EGOSIEVE_RETURN_IF_ERROR(scorer.Score(line));
    }
    if (!after_frame()) return absl::CancelledError("interrupted; nothing was written");
  }
  EGOSIEVE_RETURN_IF_ERROR(scorer.misfits().status());
  evaluation.frames_without_map = static_cast<int64_t>(truth.frames().size()) - matched;
  evaluation.points = truth.points();
  evaluation.points_outside = scorer.points_outside();
  evaluation.frames_without_points = scorer.frames_without_points();
  DriveScores scores = scorer.TakeScores();
  if (scores.frames().empty()) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "no frame of %s can be scored against %s (%d frames, %d of them with the prior only; truth "
        "for %d frames, matched by %s, void in %d; %d points outside the image); give the truth of "
        "this drive, or choose --match",
        folder.path(), truth_path, lines.size(), evaluation.frames_of_prior, truth.frames().size(),
        truth.matched_by(), evaluation.frames_without_points, evaluation.points_outside));
  }
  Summarise(scores, &evaluation);
  MaskScores masks = scorer.TakeMasks();
  if (masks.frames() > 0) evaluation.masks = masks.ToJson();
  evaluation.scores_summary += masks.Summary();
  return RunEvaluation{std::move(evaluation), std::move(scores), std::move(masks)};
}

}  // namespace egosieve::tools
