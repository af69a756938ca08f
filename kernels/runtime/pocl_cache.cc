#include "kernels/runtime/pocl_cache.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>

#include "absl/strings/str_cat.h"

namespace egosieve::kernels {
namespace {

// Whether a file can be made in `folder`, or in the nearest parent that exists.
bool CanWriteBelow(std::string folder) {
  while (access(folder.c_str(), F_OK) != 0) {
    const size_t slash = folder.rfind('/');
    if (slash == std::string::npos || slash == 0) return false;
    folder.resize(slash);
  }
  return access(folder.c_str(), W_OK | X_OK) == 0;
}

// Empty where PoCL has none.
std::string DefaultFolder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME")) return absl::StrCat(cache, "/pocl/kcache");
  if (const char* home = std::getenv("HOME")) return absl::StrCat(home, "/.cache/pocl/kcache");
  return "";
}

std::string TemporaryFolder() {
  const char* temporary = std::getenv("TMPDIR");
  return absl::StrCat(temporary != nullptr ? temporary : "/tmp", "/egosieve-pocl-", getuid());
}

}  // namespace

std::string PoclCacheFolder() {
  if (const char* chosen = std::getenv("POCL_CACHE_DIR")) return chosen;
  const std::string folder = DefaultFolder();
  return !folder.empty() && CanWriteBelow(folder) ? folder : TemporaryFolder();
}

void SetPoclCacheFolder() {
  if (std::getenv("POCL_CACHE_DIR") != nullptr || PoclCacheFolder() != TemporaryFolder()) return;
  const std::string folder = TemporaryFolder();
  mkdir(folder.c_str(), 0700);
  struct stat status;
  if (lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == getuid()) {
    setenv("POCL_CACHE_DIR", folder.c_str(), 0);
  }
}

}  // namespace egosieve::kernels
