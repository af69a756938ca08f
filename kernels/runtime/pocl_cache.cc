#include "kernels/runtime/pocl_cache.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "absl/strings/str_cat.h"

namespace egosieve::kernels {
namespace {

// Whether a file can be created in `folder`, or in its nearest existing parent.
bool CanWriteBelow(std::string folder) {
  while (access(folder.c_str(), F_OK) != 0) {
    const size_t slash = folder.rfind('/');
    if (slash == std::string::npos || slash == 0) return false;
    folder.resize(slash);
  }
  return access(folder.c_str(), W_OK | X_OK) == 0;
}

}  // namespace

std::string PoclCacheFolder() {
  if (const char* chosen = std::getenv("POCL_CACHE_DIR")) return chosen;
  if (const char* cache = std::getenv("XDG_CACHE_HOME")) return absl::StrCat(cache, "/pocl/kcache");
  if (const char* home = std::getenv("HOME")) return absl::StrCat(home, "/.cache/pocl/kcache");
  return "";
}

bool PoclCanWrite() { return CanWriteBelow(PoclCacheFolder()); }

void LetPoclWrite() {
  if (std::getenv("POCL_CACHE_DIR") != nullptr || PoclCanWrite()) return;
  const char* temporary = std::getenv("TMPDIR");
  const std::string folder =
      absl::StrCat(temporary != nullptr ? temporary : "/tmp", "/egosieve-pocl-", getuid());
  mkdir(folder.c_str(), 0700);
  struct stat status;
  if (lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == getuid()) {
    setenv("POCL_CACHE_DIR", folder.c_str(), /*overwrite=*/0);
  }
}

}  // namespace egosieve::kernels
