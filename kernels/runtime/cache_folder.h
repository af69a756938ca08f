// The user's cache folder and the files in it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace egosieve::kernels {

// $EGOSIEVE_CACHE_DIR, else $XDG_CACHE_HOME/egosieve, else $HOME/.cache/egosieve; empty if none is
// set. It need not exist.
std::string CacheFolder();

// FNV-1a, 64 bits.
uint64_t HashBytes(std::string_view bytes);

// The whole file; empty if it cannot be read.
std::string ReadCacheFile(const std::string& path);

// Creates the folders and writes the file atomically (kernels/files/atomic_file.h).
absl::Status WriteCacheFile(const std::string& path, std::string_view bytes);

}  // namespace egosieve::kernels
