#include "kernels/runtime/pocl_cache.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "absl/strings/str_cat.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"

namespace egosieve::kernels {
namespace {

// A program of PoCL's takes up to about so many bytes.
constexpr size_t kProgramBytes = 65536;

// `folder`, or its nearest existing parent; empty if there is none but the root.
std::string ExistingPart(std::string folder) {
  while (access(folder.c_str(), F_OK) != 0) {
    const size_t slash = folder.rfind('/');
    if (slash == std::string::npos || slash == 0) return "";
    folder.resize(slash);
  }
  return folder;
}

}  // namespace

std::string PoclCacheFolder() {
  if (const char* chosen = std::getenv("POCL_CACHE_DIR")) return chosen;
  if (const char* cache = std::getenv("XDG_CACHE_HOME")) return absl::StrCat(cache, "/pocl/kcache");
  if (const char* home = std::getenv("HOME")) return absl::StrCat(home, "/.cache/pocl/kcache");
  return "";
}

absl::Status CheckPoclCanWrite() {
  const std::string folder = PoclCacheFolder(), existing = ExistingPart(folder);
  if (existing.empty()) return absl::PermissionDeniedError(absl::StrCat("cannot write ", folder));
  const std::string path = absl::StrCat(existing, "/egosieve-room");
  EGOSIEVE_ASSIGN_OR_RETURN(const TemporaryFile file, TemporaryFile::Create(path));
  return WriteAll(file.descriptor(), std::string(kProgramBytes, '\0'), path);
}

void LetPoclWrite() {
  if (std::getenv("POCL_CACHE_DIR") != nullptr) return;
  const std::string existing = ExistingPart(PoclCacheFolder());
  if (!existing.empty() && access(existing.c_str(), W_OK | X_OK) == 0) return;
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
