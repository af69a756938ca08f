// The drives of a batch, and the commands for each.
//
// A manifest in TOML: one table per drive, in the file's order. Its keys are the drive's input, its
// run folder and flags of `segment`; subtables hold flags of the commands that follow. The table
// `defaults` holds the settings that all drives share; a drive's own keys override it:
//
//   [defaults]
//   out = "out"                        # run folders are out/NAME if a drive names none
//   then = ["reconstruct", "masks"]
//   profile = "fast"
//   [defaults.masks]
//   for = "colmap"
//
//   [a]
//   path = "a.mp4"
//   stride = 3
//
// Drives without a name are tables [[drives]] with path and out. In JSON: a list of objects, in
// which all but path and out may be missing, or {"defaults": {...}, "drives": [...]}:
//
//   [{"path": "a.mp4", "out": "out/a", "flags": {"stride": 3}, "masks": {"for": "colmap"}}, ...]
//
// "cuts", a list of frame numbers, gives the beginnings of a drive's further pieces, for plans
// (plan.h).
//
// true means a flag without a value; false turns a flag off (--video=false). Paths are relative to
// the manifest's folder.
#ifndef EGOSIEVE_TOOLS_BATCH_MANIFEST_H_
#define EGOSIEVE_TOOLS_BATCH_MANIFEST_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "tools/batch/batch_settings.h"

namespace egosieve::tools {

struct BatchStep {
  std::string command;
  std::vector<std::string> flags;  // "--stride=2"
};

struct BatchEntry {
  std::string path;                  // of the drive's input
  std::string out;                   // its run folder
  std::vector<std::string> flags;    // of segment
  std::vector<BatchStep> then = {};  // commands that follow, in this order
  std::vector<int64_t> cuts = {};    // frames at which a further piece begins, ascending
};

// A drive of this name; the name becomes that of its run folder in `given.out`.
BatchEntry MakeEntry(const std::string& name, const std::string& path, const BatchSettings& given);

// InvalidArgument, with the entry's number from 1 and the error; also if there are no entries.
// `folder`: the manifest's. `given` overrides the manifest's settings, except its out.
absl::StatusOr<std::vector<BatchEntry>> ParseManifest(absl::string_view text,
                                                      const std::string& folder,
                                                      const BatchSettings& given = {});

// Reads the file at `path`; errors name it.
absl::StatusOr<std::vector<BatchEntry>> ReadManifest(const std::string& path,
                                                     const BatchSettings& given = {});

// InvalidArgument if two entries have the same run folder.
absl::Status CheckFolders(const std::vector<BatchEntry>& entries);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_MANIFEST_H_
