// The folder of PoCL's compiled programs. If PoCL cannot write there (a read-only home, a sandbox),
// it builds nothing or offers no device; if the folder is damaged, it ends the process.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace egosieve::kernels {

// $POCL_CACHE_DIR, else pocl/kcache below $XDG_CACHE_HOME or $HOME/.cache; empty if none of them is
// set.
std::string PoclCacheFolder();

// Whether there is room for a program in that folder, tried by writing a temporary file; else a
// status that says why not.
absl::Status CheckPoclCanWrite();

// If the permissions do not let PoCL write there, sets POCL_CACHE_DIR to a private temporary folder. For
// programs, before they start threads: a library must not change its process's environment.
void LetPoclWrite();

}  // namespace egosieve::kernels
