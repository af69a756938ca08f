// Files that are either whole or absent, whatever moment the power fails; every file that Egosieve
// reads or writes itself goes through here.
//
//   WriteFileAtomically   bytes to a temporary file beside `path`, fsync, rename over `path`, fsync
//                         of the folder. After an error the old file, if any, is as it was; but
//                         where it is the folder's fsync that fails, as on a dying disk, the new
//                         file has its name and is whole, and may lose the name with the power.
//   TemporaryFile         the same for files that a library writes by their name
//   ReadFile              every byte or an error: a read that fails is no end of the file
//
// A temporary file is `path`.XXXXXX.tmp with random X. It is created exclusively, so that no link
// is followed, and locked until it has its name: a file left by a killed program is recognised by
// the missing lock.
//
// Errors name the path, the system's reason and what to do: NotFound, PermissionDenied,
// ResourceExhausted for a full disk, quota or memory, FailedPrecondition for what is no regular
// file (links, devices, pipes and folders are neither replaced nor waited for), else Unavailable.
#ifndef EGOSIEVE_KERNELS_FILES_ATOMIC_FILE_H_
#define EGOSIEVE_KERNELS_FILES_ATOMIC_FILE_H_

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

// FailedPrecondition, too, for more than `maximum_bytes`, which are not read then.
absl::StatusOr<std::string> ReadFile(const std::string& path,
                                     int64_t maximum_bytes = std::numeric_limits<int64_t>::max());

// Creates the folder and its parents where they are missing.
absl::Status CreateFolder(const std::string& path);

// The names in a folder, sorted.
absl::StatusOr<std::vector<std::string>> ListFolder(const std::string& path);

// What a system call's `error` (errno) means for writing `path`.
absl::Status WriteError(const std::string& path, int error);
// All of `bytes` to the open file `descriptor` of that path.
absl::Status WriteAll(int descriptor, std::string_view bytes, const std::string& path);
// Makes the names in the folder that holds `path` durable.
absl::Status SyncFolderOf(const std::string& path);

class TemporaryFile {
 public:
  // `extension` comes last in the temporary's name, for libraries that depend on it.
  static absl::StatusOr<TemporaryFile> Create(const std::string& path,
                                              const std::string& extension = "");
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&& other) noexcept;
  ~TemporaryFile();  // removes what was not committed

  const std::string& name() const { return name_; }
  int descriptor() const { return descriptor_; }
  // Syncs what was written and gives it its name.
  absl::Status Commit();

 private:
  TemporaryFile(std::string path, std::string name, int descriptor)
      : path_(std::move(path)), name_(std::move(name)), descriptor_(descriptor) {}

  std::string path_, name_;  // name_ is empty once committed or moved from
  int descriptor_ = -1;
};

// Of a file's name: what a temporary of that name was to become; empty for other names.
std::string_view NameOfTemporary(std::string_view name);

// Removes the temporary files of writers that were killed, in this folder alone. What cannot be
// removed does no harm and stays.
void RemoveAbandonedTemporaries(const std::string& folder);

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_FILES_ATOMIC_FILE_H_
