// The user's cache folder.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace egosieve::kernels {

// $EGOSIEVE_CACHE_DIR, else $XDG_CACHE_HOME/egosieve, else $HOME/.cache/egosieve; empty if none is
// set. It need not exist.
std::string CacheFolder();

// FNV-1a, 64 bits.
uint64_t HashBytes(std::string_view bytes);

}  // namespace egosieve::kernels
