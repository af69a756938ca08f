#include "tools/evaluate/scored_maps.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {

absl::StatusOr<FrameMaps> ReadScoredMaps(const RunFolder& folder, const RunDescription& description,
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
                     "; run egosieve reconstruct --what=probability on it first, or use "
                     "--pixels=grid"));
  }
  EGOSIEVE_RETURN_IF_ERROR(probability.status());
  absl::StatusOr<cv::Mat1f> deviation = ReadMap(folder.FrameFile("full", line.index, ".std.png"),
                                                size, description.deviation_full_scale);
  return FrameMaps{
      *std::move(probability), deviation.ok() ? *std::move(deviation) : cv::Mat1f(), {}};
}

kernels::ImageGrid ScoredGrid(const FrameLine& line, const RunDescription& description,
                              ScoredPixels pixels) {
  kernels::ImageGrid grid = GridOf(line, description);
  if (pixels == ScoredPixels::kFull) grid.stride = 1;
  return grid;
}

absl::StatusOr<std::vector<ScorableLine>> ReadScorableLines(const RunFolder& folder) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::vector<FrameLine> lines, folder.ReadLines());
  std::vector<ScorableLine> scorable;
  bool learnt = false;
  for (FrameLine& line : lines) {
    learnt |= line.model_size > 0 || line.outcome == FrameLine::Outcome::kLearnt;
    if (line.has_map()) scorable.push_back({std::move(line), !learnt});
  }
  return scorable;
}

}  // namespace egosieve::tools
