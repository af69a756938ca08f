// Locks on a run folder. They end with the object or the process, however that ends, and leave no
// file. File systems without locks grant every lock.
//
//   Take    what writes the log of the frames: segment, from beginning to end
//   Use     what needs the run to stay: infer, in the run whose models it reads and in the one that
//           it fills. Several programs may hold it, beside the one of Take.
//   Clear   what removes the run
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_

#include <string>
#include <utility>

#include "absl/status/statusor.h"

namespace egosieve::tools {

class FolderLock {
 public:
  // FailedPrecondition where another program's lock excludes it; Unavailable where there is no such
  // folder.
  static absl::StatusOr<FolderLock> Take(const std::string& path);
  static absl::StatusOr<FolderLock> Use(const std::string& path);
  static absl::StatusOr<FolderLock> Clear(const std::string& path);
  // Whether a program holds the lock of Take now.
  static absl::StatusOr<bool> IsTaken(const std::string& path);
  // Waits for programs that hold it for a moment; after a minute as Take.
  static absl::StatusOr<FolderLock> TakeWhenFree(const std::string& path);

  FolderLock(FolderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
  static absl::StatusOr<FolderLock> Lock(const std::string& run, const std::string& folder,
                                         int operation, const char* doing);
  int descriptor_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_
