#include "tools/evaluate/evaluate_run.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluation/drive_scores.h"
#include "tools/evaluation/synthetic_truth.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

// Maps in [0, 1] or [0, full_scale] as the 16-bit pixels that they were read from.
cv::Mat1w AsWritten(const cv::Mat1f& values, double full_scale) {
  cv::Mat1w pixels(values.size());
  for (int y = 0; y < values.rows; ++y) {
    for (int x = 0; x < values.cols; ++x) pixels(y, x) = ScoreOf(values(y, x) / full_scale);
  }
  return pixels;
}

// The maps that are scored; the deviation is left empty where the run has none.
absl::StatusOr<FrameMaps> ReadScored(const RunFolder& folder, const RunDescription& description,
                                     const FrameLine& line, ScoredPixels pixels) {
  if (pixels == ScoredPixels::kGrid) {
    absl::StatusOr<FrameMaps> maps = folder.ReadGridMaps(line, description, true);
    return absl::IsNotFound(maps.status()) ? folder.ReadGridMaps(line, description, false) : maps;
  }
  const cv::Size size(line.width_pixels, line.height_pixels);
  absl::StatusOr<cv::Mat1f> probability =
      ReadMap(folder.FrameFile("full", line.index, ".prob.png"), size, 1.0);
  if (absl::IsNotFound(probability.status())) {
    return absl::FailedPreconditionError(
        absl::StrCat("the run has no full/ map of frame ", line.index,
                     "; run egosieve reconstruct on it first, or use --pixels=grid"));
  }
  EGOSIEVE_RETURN_IF_ERROR(probability.status());
  absl::StatusOr<cv::Mat1f> deviation = ReadMap(folder.FrameFile("full", line.index, ".std.png"),
                                                size, description.deviation_full_scale);
  return FrameMaps{*std::move(probability), deviation.ok() ? *std::move(deviation) : cv::Mat1f()};
}

template <typename T>
cv::Mat_<T> AtGrid(const cv::Mat_<T>& image, const kernels::ImageGrid& grid) {
  cv::Mat_<T> sampled(grid.rows(), grid.columns());
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      sampled(row, column) = image(grid.y_pixels(row), grid.x_pixels(column));
    }
  }
  return sampled;
}

// Scores frames; knows the objects where the truth is a synthetic drive.
class FrameScorer {
 public:
  static absl::StatusOr<FrameScorer> Create(const std::string& truth,
                                            const EvaluateOptions& options, int stride) {
    EGOSIEVE_RETURN_IF_ERROR(options.scores.Validate());
    DriveScoresOptions scores = options.scores;
    if (options.pixels == ScoredPixels::kGrid) {
      scores.objects.min_area = std::max(1, scores.objects.min_area / (stride * stride));
    }
    FrameScorer scorer(scores);
    if (IsSyntheticTruth(truth)) {
      EGOSIEVE_ASSIGN_OR_RETURN(scorer.synthetic_, ReadSyntheticTruth(truth));
    }
    return scorer;
  }

  absl::StatusOr<FrameEvaluation> Score(const FrameLine& line, const RunDescription& description,
                                        const FrameMaps& maps, const cv::Mat1b& truth,
                                        const kernels::ImageGrid& grid) {
    ScoredFrame frame;
    frame.index = line.index;
    frame.probability = AsWritten(maps.probability, 1.0);
    if (!maps.deviation.empty()) {
      frame.deviation = AsWritten(maps.deviation, description.deviation_full_scale);
    }
    frame.truth = AtGrid(truth, grid);
    if (synthetic_.frames.count(line.index) > 0) {
      EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1i ids, synthetic_.ReadMovingIds(line.index));
      if (ids.size() == truth.size()) {
        frame.ids = AtGrid(ids, grid);
        frame.objects = &synthetic_.frames.at(line.index);
      }
    }
    EGOSIEVE_RETURN_IF_ERROR(scores_.Add(frame));
    FrameEvaluation evaluation;
    evaluation.index = line.index;
    evaluation.void_pixels = cv::countNonZero(frame.truth == kTruthVoid);
    evaluation.dynamic_pixels = cv::countNonZero(frame.truth == kTruthDynamic);
    evaluation.static_pixels = static_cast<int64_t>(frame.truth.total()) - evaluation.void_pixels -
                               evaluation.dynamic_pixels;
    evaluation.auc = scores_.frames().back().auc;
    return evaluation;
  }

  const DriveScores& scores() const { return scores_; }

 private:
  explicit FrameScorer(const DriveScoresOptions& options) : scores_(options) {}

  DriveScores scores_;
  SyntheticTruth synthetic_;
};

// Which lines have masks, and the masks' paths. By order, mask k is that of the k-th line.
std::map<int64_t, std::string> MasksByIndex(const TruthMasks& masks,
                                            const std::vector<FrameLine>& lines) {
  if (masks.matched_by != "order") {
    return masks.paths;
  }
  std::map<int64_t, std::string> paths;
  int64_t behind = lines.empty() ? 0 : lines.back().index + 1;
  for (const auto& [rank, path] : masks.paths) {
    const bool has_line = rank < static_cast<int64_t>(lines.size());
    paths[has_line ? lines[rank].index : behind++] = path;
  }
  return paths;
}

void Summarise(const DriveScores& scores, Evaluation& evaluation) {
  evaluation.pooled_auc = scores.pooled().Auc();
  evaluation.scores = scores.ToJson();
  evaluation.scores_summary = scores.Summary();
  double sum = 0.0;
  int64_t count = 0;
  for (const FrameEvaluation& frame : evaluation.frames) {
    if (frame.auc) {
      sum += *frame.auc;
      ++count;
    }
  }
  if (count > 0) {
    evaluation.mean_auc = sum / static_cast<double>(count);
  }
}

}  // namespace

absl::StatusOr<Evaluation> EvaluateRun(const RunFolder& folder, const std::string& truth,
                                       const EvaluateOptions& options,
                                       const std::function<bool()>& after_frame) {
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  EGOSIEVE_ASSIGN_OR_RETURN(
      const TruthMasks masks,
      ListTruthMasks(truth, FrameNames(description.input.path), options.match));
  std::map<int64_t, std::string> paths = MasksByIndex(masks, lines);

  Evaluation evaluation;
  evaluation.truth = std::filesystem::absolute(truth).lexically_normal().string();
  evaluation.matched_by = masks.matched_by;
  evaluation.pixels = options.pixels == ScoredPixels::kGrid ? "grid" : "full";
  EGOSIEVE_ASSIGN_OR_RETURN(FrameScorer scorer,
                            FrameScorer::Create(truth, options, description.grid.stride));
  bool learnt = options.with_prior;
  for (const FrameLine& line : lines) {
    learnt |= line.model_size > 0;
    if (line.outcome == FrameLine::Outcome::kFailed) continue;  // its mask counts as without a map
    const auto mask = paths.extract(line.index);
    if (mask.empty()) {
      ++evaluation.frames_without_mask;
    } else if (!learnt) {
      ++evaluation.frames_of_prior;
    } else {
      EGOSIEVE_ASSIGN_OR_RETURN(const FrameMaps maps,
                                ReadScored(folder, description, line, options.pixels));
      EGOSIEVE_ASSIGN_OR_RETURN(
          const cv::Mat1b labels,
          ReadTruthMask(mask.mapped(), cv::Size(line.width_pixels, line.height_pixels)));
      kernels::ImageGrid grid = GridOf(line, description);
      grid.stride = options.pixels == ScoredPixels::kGrid ? grid.stride : 1;
      EGOSIEVE_ASSIGN_OR_RETURN(const FrameEvaluation frame,
                                scorer.Score(line, description, maps, labels, grid));
      evaluation.frames.push_back(frame);
    }
    if (!after_frame()) {
      return absl::CancelledError("interrupted; nothing was written");
    }
  }
  evaluation.frames_without_map = static_cast<int64_t>(paths.size());
  if (evaluation.frames.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("no frame of ", folder.path(), " can be scored against ", truth, " (",
                     lines.size(), " frames, ", masks.paths.size(), " masks, matched by ",
                     masks.matched_by, "); give the masks of this drive, or choose --match"));
  }
  Summarise(scorer.scores(), evaluation);
  return evaluation;
}

}  // namespace egosieve::tools
