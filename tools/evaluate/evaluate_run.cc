#include "tools/evaluate/evaluate_run.h"

#include <cmath>
#include <filesystem>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluation/roc.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

// 16-bit scores: the map's own pixels, which ReadMap divided by 65535.
uint16_t Score(float probability) {
  return static_cast<uint16_t>(std::lround(probability * 65535.0f));
}

absl::StatusOr<cv::Mat1f> ReadScored(const RunFolder& folder, const RunDescription& description,
                                     const FrameLine& line, ScoredPixels pixels) {
  if (pixels == ScoredPixels::kGrid) {
    EGOSIEVE_ASSIGN_OR_RETURN(FrameMaps maps, folder.ReadGridMaps(line, description, false));
    return maps.probability;
  }
  absl::StatusOr<cv::Mat1f> full = ReadMap(folder.FrameFile("full", line.index, ".prob.png"),
                                           cv::Size(line.width_pixels, line.height_pixels), 1.0);
  if (absl::IsNotFound(full.status())) {
    return absl::FailedPreconditionError(
        absl::StrCat("the run has no full/ map of frame ", line.index,
                     "; run egosieve reconstruct on it first, or use --pixels=grid"));
  }
  return full;
}

FrameEvaluation ScoreFrame(const cv::Mat1f& probability, const cv::Mat1b& truth,
                           const kernels::ImageGrid& grid, RocHistogram& roc) {
  FrameEvaluation frame;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const uint8_t label = truth(grid.y_pixels(row), grid.x_pixels(column));
      if (label == kTruthVoid) {
        ++frame.void_pixels;
        continue;
      }
      const bool dynamic = label == kTruthDynamic;
      ++(dynamic ? frame.dynamic_pixels : frame.static_pixels);
      roc.Add(Score(probability(row, column)), dynamic);
    }
  }
  frame.auc = roc.Auc();
  return frame;
}

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

void Summarise(const RocHistogram& pooled, Evaluation& evaluation) {
  evaluation.pooled_auc = pooled.Auc();
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
  RocHistogram pooled;
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
      EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1f probability,
                                ReadScored(folder, description, line, options.pixels));
      EGOSIEVE_ASSIGN_OR_RETURN(
          const cv::Mat1b labels,
          ReadTruthMask(mask.mapped(), cv::Size(line.width_pixels, line.height_pixels)));
      kernels::ImageGrid grid = GridOf(line, description);
      grid.stride = options.pixels == ScoredPixels::kGrid ? grid.stride : 1;
      RocHistogram roc;
      FrameEvaluation frame = ScoreFrame(probability, labels, grid, roc);
      frame.index = line.index;
      evaluation.frames.push_back(frame);
      pooled.Merge(roc);
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
  Summarise(pooled, evaluation);
  return evaluation;
}

}  // namespace egosieve::tools
