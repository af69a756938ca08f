// Files that are there whole or not at all.
#ifndef EGOSIEVE_GP_IO_WHOLE_FILE_H_
#define EGOSIEVE_GP_IO_WHOLE_FILE_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace egosieve::gp {

// Writes by a temporary file beside `path`, fsync, rename, and fsync of the folder: after a crash
// the old file is there or the new one. On error (named with the path) the old one is untouched and
// no temporary file is left.
absl::Status WriteWholeFile(const std::string& path, std::string_view bytes);

// NotFound; FailedPrecondition, without reading it, for what is no regular file or larger than
// `maximum_bytes`; Unavailable for errors of the system.
absl::StatusOr<std::string> ReadWholeFile(const std::string& path, int64_t maximum_bytes);

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_IO_WHOLE_FILE_H_
