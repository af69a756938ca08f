// A camera's lens, read from a file: a run's camera.json, or COLMAP's cameras.txt.
//
// Of cameras.txt (tools/colmap), the first camera is used. All models but EQUIRECTANGULAR begin with
// the focal length, or with f_x and f_y, of which the mean is used. Principal point and distortion
// are not used.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

// Focal length over the longer side. DataLoss, naming the error.
absl::StatusOr<double> ReadFocalRatio(const std::string& path);

// The same for the text of a cameras.txt, and of a camera.json.
absl::StatusOr<double> FocalRatioOfColmap(absl::string_view text);
absl::StatusOr<double> FocalRatioOfCamera(absl::string_view json);

}  // namespace egosieve::tools
