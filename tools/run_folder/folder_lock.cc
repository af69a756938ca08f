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

constexpr char kFile[] = ".write.lock";

}  // namespace

absl::StatusOr<FolderLock> FolderLock::Take(const std::string& run) {
  const std::string path = absl::StrCat(run, "/", kFile);
  // NFS grants an exclusive lock only to a file that is open for writing.
  FolderLock lock(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666));
  if (lock.descriptor_ < 0) {
    return absl::UnavailableError(absl::StrCat("cannot lock ", run, " by ", path, ": ",
                                               std::strerror(errno),
                                               "; check that it is a folder you may write"));
  }
  if (flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return absl::FailedPreconditionError(absl::StrCat("another program is writing into ", run,
                                                      "; wait until it has ended, or end it"));
  }
  return lock;
}

bool FolderLock::IsLockFile(std::string_view name) { return name == kFile; }

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace egosieve::tools
