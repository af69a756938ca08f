// Files that `--overwrite` removes: those that the program itself writes into a run folder, known
// by their names, and no others.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::tools {

// Removes these files and their temporary files, run.json last: until then the folder remains a run
// folder. Links are not followed. Returns the names, relative to `path`, of everything that
// remains, except the lock files (folder_lock.h).
absl::StatusOr<std::vector<std::string>> RemoveFormerRun(const std::string& path);

// Removes the partial files of killed programs, in the run folder and in its own subfolders. Files
// that are being written, and other names, stay.
void RemoveAbandonedFiles(const std::string& path);

// Whether the folder holds only files of a run that was killed before it wrote run.json.
absl::StatusOr<bool> IsBarelyBegun(const std::string& path);

// InvalidArgument, naming the flag --out, if one of `sources` is `out` or lies in it. Links and
// other spellings of a path are resolved. Paths that do not exist lie nowhere.
absl::Status CheckApart(const std::string& out, const std::vector<std::string>& sources);

// Whether `path` is the folder or lies in it. Links and other spellings of a path are resolved.
bool LiesInFolder(const std::string& path, const std::string& folder);

}  // namespace egosieve::tools
