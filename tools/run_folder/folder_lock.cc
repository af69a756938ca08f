#include "tools/run_folder/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace egosieve::tools {
namespace {

constexpr char kWrite[] = ".write.lock", kUse[] = ".use.lock";

// NFS grants an exclusive lock only to a file that is open for writing. Readers of a folder that
// they may not write open what is there.
int OpenLockFile(const std::string& path, bool is_shared) {
  constexpr int kFlags = O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | kFlags, 0666);
  const bool may_read = is_shared && (errno == EACCES || errno == EPERM || errno == EROFS);
  return descriptor < 0 && may_read ? open(path.c_str(), O_RDONLY | kFlags) : descriptor;
}

}  // namespace

absl::StatusOr<FolderLock> FolderLock::Lock(const std::string& run, const char* file, int operation,
                                            const char* doing) {
  const std::string path = absl::StrCat(run, "/", file);
  FolderLock lock(OpenLockFile(path, operation == LOCK_SH));
  if (lock.descriptor_ < 0) {
    // A run on a medium that nobody writes has no lock file and needs none.
    if (operation == LOCK_SH && errno == ENOENT && access(run.c_str(), F_OK) == 0) return lock;
    return absl::UnavailableError(absl::StrCat("cannot lock ", run, " by ", path, ": ",
                                               std::strerror(errno),
                                               "; check that it is a folder you may write"));
  }
  if (flock(lock.descriptor_, operation | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return absl::FailedPreconditionError(absl::StrCat("another program is ", doing, " ", run,
                                                      "; wait until it has ended, or end it"));
  }
  return lock;
}

absl::StatusOr<FolderLock> FolderLock::Take(const std::string& path) {
  return Lock(path, kWrite, LOCK_EX, "writing into");
}

absl::StatusOr<FolderLock> FolderLock::Use(const std::string& path) {
  return Lock(path, kUse, LOCK_SH, "removing");
}

absl::StatusOr<FolderLock> FolderLock::Clear(const std::string& path) {
  return Lock(path, kUse, LOCK_EX, "working with");
}

bool FolderLock::IsLockFile(std::string_view name) { return name == kWrite || name == kUse; }

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace egosieve::tools
