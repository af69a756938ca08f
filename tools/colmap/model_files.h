// The files of COLMAP's sparse model, as bytes. Every count is compared with what is left of the
// file before anything is allocated for it.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "tools/colmap/sparse_model.h"

namespace egosieve::tools {

// Of SparseCamera, SparseImage or SparsePoint. DataLoss, naming byte or line; bytes after the last
// item are an error, too.
template <typename Item>
absl::StatusOr<std::vector<Item>> Parse(absl::string_view bytes, bool is_text);

// Text has 17 digits, from which every number is read again as it was.
std::string Format(const std::vector<SparseCamera>& cameras, bool is_text);
std::string Format(const std::vector<SparseImage>& images, bool is_text);
std::string Format(const std::vector<SparsePoint>& points, bool is_text);

}  // namespace egosieve::tools
