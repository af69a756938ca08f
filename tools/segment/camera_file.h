// camera.json: the lens of a run, or of a drive's truth.
#ifndef EGOSIEVE_TOOLS_SEGMENT_CAMERA_FILE_H_
#define EGOSIEVE_TOOLS_SEGMENT_CAMERA_FILE_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

// The focal length over the longer side. DataLoss, naming the field.
absl::StatusOr<double> FocalRatioOfCamera(absl::string_view json);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SEGMENT_CAMERA_FILE_H_
