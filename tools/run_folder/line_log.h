// A text file that grows by complete lines. Append returns after the line is synced to the disk. A
// line that could not be written completely is cut off again.
//
// Errors are those of kernels/files/atomic_file.h.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

class LineLog {
 public:
  // Opens for appending and creates the file if needed. A last line without a line break comes from
  // a crash and is cut off.
  static absl::StatusOr<LineLog> Open(const std::string& path);
  // The same, after cutting the file to its first `lines` lines; DataLoss if it has fewer.
  static absl::StatusOr<LineLog> OpenTruncated(const std::string& path, int64_t lines);

  LineLog(LineLog&& other) noexcept;
  LineLog& operator=(LineLog&& other) noexcept;
  ~LineLog();

  // `line` without its final line break; several lines are separated by line breaks.
  absl::Status Append(absl::string_view line);

 private:
  LineLog(std::string path, int descriptor, int64_t size)
      : path_(std::move(path)), descriptor_(descriptor), size_(size) {}
  static absl::StatusOr<LineLog> OpenWithSize(const std::string& path, int64_t size);

  std::string path_;
  int descriptor_ = -1;
  int64_t size_ = 0;  // bytes of whole lines
};

}  // namespace egosieve::tools
