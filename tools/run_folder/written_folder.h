// Checks a folder before a command writes to it.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace egosieve::tools {

// InvalidArgument if the folder lies in one of the folders `sources`, or is or holds one of the
// `files`. AlreadyExists if it is a file, or if it holds something and is not allowed to
// (`may_hold`). flag: as the message names the path, for example "--out".
absl::Status CheckWrittenFolder(const std::string& flag, const std::string& path,
                                const std::set<std::string>& sources,
                                const std::vector<std::string>& files, bool may_hold);

}  // namespace egosieve::tools
