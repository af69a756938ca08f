// Files that are either whole or absent, whatever moment the power fails.
//
//   WriteFileAtomically   bytes to a temporary file beside `path`, fsync, rename over `path`, fsync
//                         of the folder. After an error the old file, if any, is as it was.
//   LineLog               a text file that grows by whole lines, each synced before Append returns.
//                         A line that could not be written whole is cut off again.
//
// Errors: ResourceExhausted for a full disk or quota, PermissionDenied, else Unavailable; each
// names the path, the system's reason and what to do.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_ATOMIC_FILE_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_ATOMIC_FILE_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

absl::Status WriteFileAtomically(const std::string& path, absl::string_view bytes);

// NotFound or PermissionDenied, naming the path.
absl::StatusOr<std::string> ReadFile(const std::string& path);

// Creates the folder and its parents where they are missing.
absl::Status CreateFolder(const std::string& path);

class LineLog {
 public:
  // Opens for appending, creating the file. A last line without its line break is what a crash
  // left: it is cut off.
  static absl::StatusOr<LineLog> Open(const std::string& path);
  // Likewise, after cutting the file to its first `lines` lines; DataLoss if it has fewer.
  static absl::StatusOr<LineLog> OpenTruncated(const std::string& path, int64_t lines);

  LineLog(LineLog&& other) noexcept;
  LineLog& operator=(LineLog&& other) noexcept;
  ~LineLog();

  // `line` without its line break; several lines with those between them.
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

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_ATOMIC_FILE_H_
