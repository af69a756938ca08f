// The lock on a run folder, by flock on .write.lock in it, which stays: locks on folders exclude
// nothing on NFS. Held by the program that writes or removes the run: segment, refine, merge.
// It ends with its object or its process, even if that is killed. File systems without locks grant
// every lock.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"

namespace egosieve::tools {

class FolderLock {
 public:
  // FailedPrecondition if another program holds it; Unavailable if there is no such
  // folder.
  static absl::StatusOr<FolderLock> Take(const std::string& path);

  // Whether a file of this name in a run folder is the lock.
  static bool IsLockFile(std::string_view name);

  FolderLock(FolderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace egosieve::tools
