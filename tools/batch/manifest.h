// The drives of a batch, from a file.
//
// JSON: a list of objects, of which `flags` may be missing:
//
//   [{"path": "a.mp4", "out": "out/a", "flags": {"profile": "fast", "stride": 2}}, ...]
//
// TOML: a table a drive, in the file's order, whose other keys are the flags:
//
//   [a]
//   path = "a.mp4"
//   out = "out/a"
//   profile = "fast"
//
// Flags are those of `segment`, by the names that its --config takes; true stands for a flag
// without a value, false for none. Paths are relative to the manifest's folder.
#ifndef EGOSIEVE_TOOLS_BATCH_MANIFEST_H_
#define EGOSIEVE_TOOLS_BATCH_MANIFEST_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

struct BatchEntry {
  std::string path;                // of the drive's input
  std::string out;                 // its run folder
  std::vector<std::string> flags;  // "--stride=2", as segment takes them
};

// InvalidArgument, naming the entry's number, from 1, and what is wrong with it; also where two
// entries have the same run folder, or there is none. `folder`: the manifest's.
absl::StatusOr<std::vector<BatchEntry>> ParseManifest(absl::string_view text,
                                                      const std::string& folder);

// The file at `path`; errors name it.
absl::StatusOr<std::vector<BatchEntry>> ReadManifest(const std::string& path);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_MANIFEST_H_
