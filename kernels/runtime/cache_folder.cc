#include "kernels/runtime/cache_folder.h"

#include <cstdlib>

#include "absl/strings/str_cat.h"

namespace egosieve::kernels {

std::string CacheFolder() {
  if (const char* own = std::getenv("EGOSIEVE_CACHE_DIR"); own != nullptr && *own != '\0')
    return own;
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0') {
    return absl::StrCat(cache, "/egosieve");
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    return absl::StrCat(home, "/.cache/egosieve");
  }
  return "";
}

uint64_t HashBytes(std::string_view bytes) {
  uint64_t hash = 14695981039346656037u;
  for (const char byte : bytes) {
    hash = (hash ^ static_cast<unsigned char>(byte)) * 1099511628211u;
  }
  return hash;
}

}  // namespace egosieve::kernels
