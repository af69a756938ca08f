// What `--overwrite` removes: the files that the program writes into a run folder, by their names,
// and nothing else.
#ifndef EGOSIEVE_TOOLS_RUN_FOLDER_FORMER_RUN_H_
#define EGOSIEVE_TOOLS_RUN_FOLDER_FORMER_RUN_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::tools {

// Removes them with their temporaries, run.json last: until then the folder is still one. Links
// are not followed. Returns what is left, but for grid/, by names relative to `path`.
absl::StatusOr<std::vector<std::string>> RemoveFormerRun(const std::string& path);

// Removes what programs that were killed left half written, in the run folder and in those below it
// that are its own. Files that are being written, and other names, stay.
void RemoveAbandonedFiles(const std::string& path);

// Whether the folder holds nothing but what a run leaves that was killed before its run.json.
absl::StatusOr<bool> IsBarelyBegun(const std::string& path);

// InvalidArgument, naming the flag --out, where one of `sources` is `out` or lies in it, whatever
// names and links lead there. Paths that do not exist lie nowhere.
absl::Status CheckApart(const std::string& out, const std::vector<std::string>& sources);

// Whether `path` is the folder or lies in it, whatever names and links lead there.
bool LiesInFolder(const std::string& path, const std::string& folder);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RUN_FOLDER_FORMER_RUN_H_
