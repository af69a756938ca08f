// Locks on a run folder. A lock ends with its object or its process, even if that is killed, and
// leaves no file. File systems without locks grant every lock.
//
//   Take    held by the writer of the frames' log: segment, from beginning to end
//   Use     held by a program that needs the run to stay: infer, on the run whose models it reads
//           and on the run that it fills. Several programs may hold it, also while another one
//           holds Take
//   Clear   held while a run is removed
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_

#include <string>
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
  // Whether a program holds the lock of Take at present.
  static absl::StatusOr<bool> IsTaken(const std::string& path);
  // Waits for programs that hold the lock only briefly; after a minute it fails as Take does.
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
