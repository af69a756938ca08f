#include "tools/segment/camera_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {

absl::StatusOr<double> FocalRatioOfCamera(absl::string_view json) {
  const nlohmann::ordered_json parsed =
      nlohmann::ordered_json::parse(json.begin(), json.end(), nullptr, false);
  double focal = 0.0, width = 0.0, height = 0.0;
  JsonFields fields(parsed, "the camera");
  fields.Read("focal_pixels", focal);
  fields.Read("width", width);
  fields.Read("height", height);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  if (!(focal > 0.0) || !(width > 0.0)) {
    return absl::DataLossError(absl::StrFormat(
        "the camera: focal_pixels = %g, width = %g; they must be positive", focal, width));
  }
  return focal / std::max(width, height);
}

}  // namespace egosieve::tools
