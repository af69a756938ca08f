// Locks on a run folder, by flock on two files in it that stay: locks on folders exclude nothing on
// NFS. A lock ends with its object or its process, even if that is killed. File systems without
// locks grant every lock.
//
//   Take    .write.lock, held by the program that writes the run: segment, infer, reconstruct,
//           merge
//   Use     .use.lock, shared, held by a program that needs the run to stay: infer, on the run
//           whose models it reads. Others may hold Take meanwhile
//   Clear   .use.lock, held while a run is removed
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_

#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"

namespace egosieve::tools {

class FolderLock {
 public:
  // FailedPrecondition if another program's lock excludes it; Unavailable if there is no such
  // folder.
  static absl::StatusOr<FolderLock> Take(const std::string& path);
  static absl::StatusOr<FolderLock> Use(const std::string& path);
  static absl::StatusOr<FolderLock> Clear(const std::string& path);

  // Whether a file of this name in a run folder is one of the locks.
  static bool IsLockFile(std::string_view name);

  FolderLock(FolderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
  static absl::StatusOr<FolderLock> Lock(const std::string& run, const char* file, int operation,
                                         const char* doing);
  int descriptor_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_
