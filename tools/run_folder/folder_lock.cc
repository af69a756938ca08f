#include "tools/run_folder/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace egosieve::tools {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(20);
constexpr auto kLongestWait = std::chrono::minutes(1);

}  // namespace

absl::StatusOr<FolderLock> FolderLock::Take(const std::string& path) {
  FolderLock lock(open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.descriptor_ < 0) {
    return absl::UnavailableError(absl::StrCat("cannot lock ", path, ": ", std::strerror(errno),
                                               "; check that it is a folder you may read"));
  }
  if (flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return absl::FailedPreconditionError(absl::StrCat("another program is writing into ", path,
                                                      "; wait until it has ended, or end it"));
  }
  return lock;
}

absl::StatusOr<FolderLock> FolderLock::TakeWhenFree(const std::string& path) {
  const auto start = std::chrono::steady_clock::now();
  while (true) {
    absl::StatusOr<FolderLock> lock = Take(path);
    if (!absl::IsFailedPrecondition(lock.status()) ||
        std::chrono::steady_clock::now() - start > kLongestWait) {
      return lock;
    }
    std::this_thread::sleep_for(kPoll);
  }
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace egosieve::tools
