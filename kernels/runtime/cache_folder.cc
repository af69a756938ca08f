#include "kernels/runtime/cache_folder.h"

#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

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

std::string ReadCacheFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return "";
  return std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

absl::Status WriteCacheFile(const std::string& path, std::string_view bytes) {
  static std::atomic<int> counter = 0;
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), error);
  const std::string temporary = absl::StrCat(path, ".", getpid(), ".", counter++, ".tmp");
  std::ofstream file(temporary, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) {
    std::filesystem::rename(temporary, path, error);
    if (!error) return absl::OkStatus();
  }
  std::filesystem::remove(temporary, error);
  return absl::UnavailableError(absl::StrCat(path, " cannot be written; is its folder writable?"));
}

}  // namespace egosieve::kernels
