// camera.json: the lens of a run, or of a drive's truth.
#pragma once

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

// The focal length over the longer side. DataLoss, naming the field.
absl::StatusOr<double> FocalRatioOfCamera(absl::string_view json);

}  // namespace egosieve::tools
