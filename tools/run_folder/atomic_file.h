// Functions of kernels/files/atomic_file.h, in this namespace.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_ATOMIC_FILE_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_ATOMIC_FILE_H_

#include "kernels/files/atomic_file.h"

namespace egosieve::tools {

using kernels::CreateFolder;
using kernels::ListFolder;
using kernels::ReadFile;
using kernels::WriteFileAtomically;

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_ATOMIC_FILE_H_
