// Files that are always either whole or absent, even after a power failure. Every file that
// Egosieve itself reads or writes goes through these functions, except logs that grow
// (tools/run_folder/line_log.h), those of batch, and files of the system such as /proc.
//
//   WriteFileAtomically   bytes to a temporary file beside `path`, fsync, rename over `path`, fsync
//                         of the folder. After an error the old file, if any, is unchanged, except
//                         if the folder's fsync fails, as on a failing disk: then the new file is
//                         whole and has its name, but may lose the name at a power failure.
//   TemporaryFile         the same for files that a library writes by name
//   ReadFile              every byte or an error: a failed read is not the end of the file
//
// A temporary file is `path`.XXXXXX.egosieve.tmp with random X, a name that no other program gives.
// It is created exclusively, so that no link is followed, and locked until it gets its final name.
// So a file left by a killed program is recognised by its missing lock.
//
// Errors name the path, the system's reason and a remedy: NotFound, PermissionDenied,
// ResourceExhausted for a full disk, quota or memory, FailedPrecondition if `path` is not a regular
// file (links, devices, pipes and folders are neither replaced nor waited for), otherwise
// Unavailable.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::kernels {

absl::Status WriteFileAtomically(const std::string& path, std::string_view bytes);

// Also FailedPrecondition for more than `maximum_bytes`; such files are not read.
absl::StatusOr<std::string> ReadFile(const std::string& path,
                                     int64_t maximum_bytes = std::numeric_limits<int64_t>::max());

// Creates the folder and its missing parents.
absl::Status CreateFolder(const std::string& path);

// The names in a folder, sorted.
absl::StatusOr<std::vector<std::string>> ListFolder(const std::string& path);

// The status of a system call's `error` (errno) on writing `path`.
absl::Status WriteError(const std::string& path, int error);
// Writes all of `bytes` to the open file `descriptor` of that path.
absl::Status WriteAll(int descriptor, std::string_view bytes, const std::string& path);
// Makes the names in the folder that holds `path` durable.
absl::Status SyncFolderOf(const std::string& path);

class TemporaryFile {
 public:
  // `extension` ends the temporary file's name, for libraries that depend on it.
  static absl::StatusOr<TemporaryFile> Create(const std::string& path,
                                              const std::string& extension = "");
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&& other) noexcept;
  ~TemporaryFile();  // removes an uncommitted file

  const std::string& name() const { return name_; }
  int descriptor() const { return descriptor_; }
  // Syncs the contents and renames the file to `path`.
  absl::Status Commit();

 private:
  TemporaryFile(std::string path, std::string name, int descriptor)
      : path_(std::move(path)), name_(std::move(name)), descriptor_(descriptor) {}

  std::string path_, name_;  // name_ is empty once committed or moved from
  int descriptor_ = -1;
};

// For a temporary file's name: its final name; empty for other names.
std::string_view NameOfTemporary(std::string_view name);

// Removes the temporary files of killed writers, in this folder alone. Files that cannot be removed
// do no harm and stay.
void RemoveAbandonedTemporaries(const std::string& folder);

}  // namespace egosieve::kernels
