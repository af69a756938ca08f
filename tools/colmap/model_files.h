// The files of COLMAP's sparse model, as bytes. Every count is compared with what is left of the
// file before anything is allocated for it.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "tools/colmap/sparse_model.h"

namespace egosieve::tools {

// DataLoss, naming byte or line. Bytes after the last item are an error, too.
absl::StatusOr<std::vector<SparseCamera>> ParseCameras(absl::string_view bytes, bool is_text);
absl::StatusOr<std::vector<SparseImage>> ParseImages(absl::string_view bytes, bool is_text);
absl::StatusOr<std::vector<SparsePoint>> ParsePoints(absl::string_view bytes, bool is_text);

// Text has 17 digits, from which every number is read again as it was.
std::string FormatCameras(const std::vector<SparseCamera>& cameras, bool is_text);
std::string FormatImages(const std::vector<SparseImage>& images, bool is_text);
std::string FormatPoints(const std::vector<SparsePoint>& points, bool is_text);

}  // namespace egosieve::tools
