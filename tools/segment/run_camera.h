// The camera of a run: learnt in a first pass over the drive and kept in the run folder's
// camera.json, from which a run that goes on takes it.
//
//   {"focal_pixels": ..., "width": ..., "height": ...,      as evaluation/trajectory_errors.h reads
//   it
//    "log_focal_deviation": ..., "pairs": ...}              how sure it is, and from how much
#ifndef EGOSIEVE_TOOLS_SEGMENT_RUN_CAMERA_H_
#define EGOSIEVE_TOOLS_SEGMENT_RUN_CAMERA_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/frame/equalization.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {

struct RunCamera {
  double focal_ratio = 0.0;  // over the longer side
  std::string text;          // of camera.json
};

// `source` at its frame `from`, of the size given; its next frame is undefined afterwards.
absl::StatusOr<RunCamera> LearnRunCamera(vision::FrameSource& source, int64_t from,
                                         int width_pixels, int height_pixels,
                                         const vision::EqualizationOptions& equalization);

// Of the run in `directory`; nothing where it has none. DataLoss for a damaged file.
absl::StatusOr<std::optional<RunCamera>> ReadRunCamera(const std::string& directory);

absl::Status WriteRunCamera(const std::string& directory, const RunCamera& camera);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_RUN_CAMERA_H_
