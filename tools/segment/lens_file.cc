#include "tools/segment/lens_file.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/colmap/model_files.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {

absl::StatusOr<double> FocalRatioOfColmap(absl::string_view text) {
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<SparseCamera> cameras,
                            Parse<SparseCamera>(text, true));
  if (cameras.empty()) return absl::DataLossError("there is no camera in it");
  const SparseCamera& camera = cameras.front();
  const int focals = FindCameraModel(camera.model)->focals;
  if (focals == 0 || camera.width == 0 || camera.height == 0) {
    return absl::DataLossError("the first camera has no focal length, width or height");
  }
  double sum = 0.0;
  for (int k = 0; k < focals; ++k) {
    const double focal = camera.parameters[k];
    if (!(focal > 0.0) || !std::isfinite(focal)) {
      return absl::DataLossError("the focal length must be a positive number");
    }
    sum += focal;
  }
  return sum / focals / static_cast<double>(std::max(camera.width, camera.height));
}

absl::StatusOr<double> FocalRatioOfCamera(absl::string_view json) {
  const nlohmann::ordered_json parsed =
      nlohmann::ordered_json::parse(json.begin(), json.end(), nullptr, false);
  double focal = 0.0, width = 0.0, height = 0.0;
  JsonFields fields(parsed, "the camera");
  fields.Field("focal_pixels", focal);
  fields.Field("width", width);
  fields.Field("height", height);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  if (!(focal > 0.0) || !(width > 0.0)) {
    return absl::DataLossError(absl::StrFormat(
        "the camera: focal_pixels = %g, width = %g; they must be positive", focal, width));
  }
  return focal / std::max(width, height);
}

absl::StatusOr<double> ReadFocalRatio(const std::string& path) {
  if (absl::EndsWith(path, ".txt")) return ParseFile(path, FocalRatioOfColmap);
  return ParseFile(path, FocalRatioOfCamera);
}

}  // namespace egosieve::tools
