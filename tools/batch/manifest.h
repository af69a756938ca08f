// The drives of a batch, and the commands for each.
//
// A manifest in TOML: one table per drive, in the file's order. Its keys are the drive's input, its
// run folder and flags of `segment`; subtables hold flags of the commands that follow. The table
// `defaults` holds the settings that all drives share; a drive's own keys override it:
//
//   [defaults]
//   out = "out"                        # run folders are out/NAME if a drive names none
//   then = ["refine", "masks"]         # refine and report without it
//   profile = "fast"
//   [defaults.masks]
//   for = "colmap"
//
//   [a]
//   path = "a.mp4"
//   stride = 3
//
// Drives without a name are tables [[drives]] with path and out. In JSON the same: an object of
// objects, or a list of drives; flags of segment may stand in an object "flags":
//
//   [{"path": "a.mp4", "out": "out/a", "flags": {"stride": 3}, "masks": {"for": "colmap"}}, ...]
//
// "research", an object, gives research settings (research_flag.h). "cuts", a list of frame numbers,
// gives the beginnings of a drive's further pieces (plan.h).
//
// true means a flag without a value; false turns a flag off (--video=false). Paths are relative to
// the manifest's folder.
#ifndef EGOSIEVE_TOOLS_BATCH_MANIFEST_H_
#define EGOSIEVE_TOOLS_BATCH_MANIFEST_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

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

// What the command line says of all drives; it goes before a manifest, except before its run
// folders.
struct BatchSettings {
  std::string out;                         // the folder for the run folders
  std::optional<std::string> then;         // "refine,masks"
  std::string segment_flags, masks_flags;  // "--stride=2 --deterministic"
};

// The commands that may follow segment.
const std::vector<std::string>& FollowingCommands();

// A drive of this name; the name becomes that of its run folder in `given.out`. InvalidArgument for
// flags and commands that do not fit.
absl::StatusOr<BatchEntry> MakeEntry(const std::string& name, const std::string& path,
                                     const BatchSettings& given);

// InvalidArgument, with the entry's number from 1 and the error; also if there are no entries.
// `folder`: the manifest's.
absl::StatusOr<std::vector<BatchEntry>> ParseManifest(absl::string_view text,
                                                      const std::string& folder,
                                                      const BatchSettings& given = {});
// Reads the file at `path`; errors name it.
absl::StatusOr<std::vector<BatchEntry>> ReadManifest(const std::string& path,
                                                     const BatchSettings& given = {});
// A manifest in JSON, with absolute paths.
std::string ToManifest(const std::vector<BatchEntry>& entries);

// InvalidArgument if two entries have the same run folder.
absl::Status CheckFolders(const std::vector<BatchEntry>& entries);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_MANIFEST_H_
