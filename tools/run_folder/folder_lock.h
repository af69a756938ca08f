// A lock on a run folder, so that no two programs write into it at a time: segment holds it from
// beginning to end, infer while it changes the log. It ends with the object or the process, however
// that ends, and leaves no file. File systems that know no locks give one that keeps nobody out.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_

#include <string>
#include <utility>

#include "absl/status/statusor.h"

namespace egosieve::tools {

class FolderLock {
 public:
  // FailedPrecondition where another program holds it; Unavailable where there is no such folder.
  static absl::StatusOr<FolderLock> Take(const std::string& path);
  // Waits for programs that hold it for a moment; after a minute as Take.
  static absl::StatusOr<FolderLock> TakeWhenFree(const std::string& path);

  FolderLock(FolderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_FOLDER_LOCK_H_
