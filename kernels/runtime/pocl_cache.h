// Where PoCL keeps what it compiles. It fails to build anything, or gives no device, where it
// cannot write there (a home that is read-only, a sandbox), and ends the process where it finds
// damage.
#ifndef EGOSIEVE_KERNELS_RUNTIME_POCL_CACHE_H_
#define EGOSIEVE_KERNELS_RUNTIME_POCL_CACHE_H_

#include <string>

namespace egosieve::kernels {

// $POCL_CACHE_DIR, else pocl/kcache below $XDG_CACHE_HOME or $HOME/.cache where that can be
// written, else a folder of the user's own among the temporary files.
std::string PoclCacheFolder();

// Makes PoCL use that folder. Before the first call into a driver.
void SetPoclCacheFolder();

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_POCL_CACHE_H_
