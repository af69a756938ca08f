// PoCL keeps what it compiles in a folder of its own and builds nothing where it cannot write there
// (a home that is read-only, a sandbox).
#ifndef EGOSIEVE_KERNELS_RUNTIME_POCL_CACHE_H_
#define EGOSIEVE_KERNELS_RUNTIME_POCL_CACHE_H_

namespace egosieve::kernels {

// Whether PoCL finds a folder that it can write to: POCL_CACHE_DIR, or below the user's cache
// folder.
bool PoclCanWrite();

// Sets POCL_CACHE_DIR to a private folder among the temporary files where PoCL cannot write. For
// programs, before they start threads: a library must not change its process's environment.
void LetPoclWrite();

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_RUNTIME_POCL_CACHE_H_
