// Where PoCL keeps what it compiles. It builds nothing, or gives no device, where it cannot write
// there (a home that is read-only, a sandbox), and ends the process where it finds damage.
#ifndef EGOSIEVE_KERNELS_RUNTIME_POCL_CACHE_H_
#define EGOSIEVE_KERNELS_RUNTIME_POCL_CACHE_H_

#include <string>

namespace egosieve::kernels {

// $POCL_CACHE_DIR, else pocl/kcache below $XDG_CACHE_HOME or $HOME/.cache; empty where none of them
// is set.
std::string PoclCacheFolder();

// Whether PoCL can write to that folder.
bool PoclCanWrite();

// Sets POCL_CACHE_DIR to a private folder among the temporary files where PoCL cannot write. For
// programs, before they start threads: a library must not change its process's environment.
void LetPoclWrite();

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_POCL_CACHE_H_
