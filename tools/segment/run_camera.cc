#include "tools/segment/run_camera.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"
#include "tools/evaluation/trajectory_errors.h"
#include "vision/labelling/drive_camera.h"

namespace egosieve::tools {
namespace {

std::string PathIn(const std::string& directory) { return absl::StrCat(directory, "/camera.json"); }

// The ratio comes from the text alone, so that a run that goes on has the bits of the first one.
absl::StatusOr<RunCamera> Parse(std::string text) {
  EGOSIEVE_ASSIGN_OR_RETURN(const CameraTruth camera, ParseCamera(text));
  return RunCamera{camera.focal_pixels / std::max(camera.width, camera.height), std::move(text)};
}

}  // namespace

absl::StatusOr<RunCamera> LearnRunCamera(vision::FrameSource& source, int64_t from,
                                         int width_pixels, int height_pixels,
                                         const vision::EqualizationOptions& equalization) {
  vision::DriveCameraOptions options;
  options.first_frame = from;
  options.equalization = equalization;
  EGOSIEVE_ASSIGN_OR_RETURN(const vision::DriveCamera camera,
                            vision::LearnDriveCamera(source, options));
  const nlohmann::ordered_json json = {
      {"focal_pixels", camera.focal_ratio * std::max(width_pixels, height_pixels)},
      {"width", width_pixels},
      {"height", height_pixels},
      {"log_focal_deviation", camera.log_focal_deviation},
      {"pairs", camera.pair_count}};
  return Parse(json.dump(2) + "\n");
}

absl::StatusOr<std::optional<RunCamera>> ReadRunCamera(const std::string& directory) {
  absl::StatusOr<std::string> text = kernels::ReadFile(PathIn(directory));
  if (absl::IsNotFound(text.status())) return std::optional<RunCamera>();
  EGOSIEVE_RETURN_IF_ERROR(text.status());
  absl::StatusOr<RunCamera> camera = Parse(*std::move(text));
  if (!camera.ok()) {
    return absl::DataLossError(absl::StrCat(PathIn(directory), ": ", camera.status().message(),
                                            "; start the run anew with --overwrite"));
  }
  return std::make_optional(*std::move(camera));
}

absl::Status WriteRunCamera(const std::string& directory, const RunCamera& camera) {
  return kernels::WriteFileAtomically(PathIn(directory), camera.text);
}

}  // namespace egosieve::tools
