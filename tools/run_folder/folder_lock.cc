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
#include "kernels/base/status_macros.h"

namespace egosieve::tools {
namespace {

constexpr char kUsed[] = "/grid";  // exists in every run
constexpr auto kPoll = std::chrono::milliseconds(20);
constexpr auto kLongestWait = std::chrono::minutes(1);

}  // namespace

absl::StatusOr<FolderLock> FolderLock::Lock(const std::string& run, const std::string& folder,
                                            int operation, const char* doing) {
  FolderLock lock(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.descriptor_ < 0) {
    return absl::UnavailableError(absl::StrCat("cannot lock ", folder, ": ", std::strerror(errno),
                                               "; check that it is a folder you may read"));
  }
  if (flock(lock.descriptor_, operation | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return absl::FailedPreconditionError(absl::StrCat("another program is ", doing, " ", run,
                                                      "; wait until it has ended, or end it"));
  }
  return lock;
}

absl::StatusOr<FolderLock> FolderLock::Take(const std::string& path) {
  constexpr int kAttempts = 5;  // IsTaken holds the lock for an instant
  for (int attempt = 1;; ++attempt) {
    absl::StatusOr<FolderLock> lock = Lock(path, path, LOCK_EX, "writing into");
    if (!absl::IsFailedPrecondition(lock.status()) || attempt == kAttempts) return lock;
    std::this_thread::sleep_for(kPoll);
  }
}

absl::StatusOr<bool> FolderLock::IsTaken(const std::string& path) {
  const absl::StatusOr<FolderLock> lock = Lock(path, path, LOCK_SH, "writing into");
  if (absl::IsFailedPrecondition(lock.status())) return true;
  EGOSIEVE_RETURN_IF_ERROR(lock.status());
  return false;
}

absl::StatusOr<FolderLock> FolderLock::Use(const std::string& path) {
  return Lock(path, absl::StrCat(path, kUsed), LOCK_SH, "removing");
}

absl::StatusOr<FolderLock> FolderLock::Clear(const std::string& path) {
  return Lock(path, absl::StrCat(path, kUsed), LOCK_EX, "working with");
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
