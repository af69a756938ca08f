// The drives of a batch, and what is done with each.
//
// A manifest in TOML: one table per drive, in the file's order, whose keys are its input, its run
// folder and flags of `segment`; tables below it hold flags of the commands that follow. The table
// `defaults` holds what all drives share, and a drive's own keys override it:
//
//   [defaults]
//   out = "out"                        # run folders are out/NAME where a drive names none
//   then = ["reconstruct", "masks"]
//   profile = "fast"
//   [defaults.masks]
//   for = "colmap"
//
//   [a]
//   path = "a.mp4"
//   stride = 3
//
// [[drives]] with path and out does for tables that are to have no name. In JSON: a list of
// objects, of which all but path and out may be missing, or {"defaults": {...}, "drives": [...]}:
//
//   [{"path": "a.mp4", "out": "out/a", "flags": {"stride": 3}, "masks": {"for": "colmap"}}, ...]
//
// "cuts", a list of frame numbers, is where a drive's further pieces begin, for plans (plan.h).
//
// true means a flag without a value, false for none. Paths are relative to the manifest's
// folder.
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

// A drive of that name, which becomes its run folder in `given.out`.
BatchEntry MakeEntry(const std::string& name, const std::string& path, const BatchSettings& given);

// InvalidArgument, naming the entry's number, from 1, and what is wrong with it; also where there
// is none. `folder`: the manifest's. `given` overrides what the manifest says, except its out.
absl::StatusOr<std::vector<BatchEntry>> ParseManifest(absl::string_view text,
                                                      const std::string& folder,
                                                      const BatchSettings& given = {});

// The file at `path`; errors name it.
absl::StatusOr<std::vector<BatchEntry>> ReadManifest(const std::string& path,
                                                     const BatchSettings& given = {});

// InvalidArgument where two entries have the same run folder.
absl::Status CheckFolders(const std::vector<BatchEntry>& entries);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_MANIFEST_H_
