// The drives of a batch, and what is done with each.
//
// A manifest in TOML: a table a drive, in the file's order, whose keys are its input, its run
// folder and flags of `segment`; tables below it hold flags of what comes behind. The table
// `defaults` holds what all drives share, and what a drive says goes before it:
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
#include <map>
#include <string>
#include <utility>
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

// What is said of drives, one or all; what is not said is empty.
struct BatchSettings {
  using Flags = std::vector<std::pair<std::string, std::string>>;  // name, value

  std::string out;
  std::vector<std::string> then;
  bool says_then = false;
  std::map<std::string, Flags> flags;  // by command
};

// The commands that may follow segment.
const std::vector<std::string>& FollowingCommands();

// Words by commas. InvalidArgument for one that is none of FollowingCommands().
absl::StatusOr<std::vector<std::string>> ParseThen(absl::string_view text);
// "--stride=2 --learn_only". InvalidArgument for words that are no flags, and for flags that the
// batch sets itself.
absl::StatusOr<BatchSettings::Flags> ParseFlags(absl::string_view text);

// A drive of that name, which becomes its run folder in `given.out`.
BatchEntry MakeEntry(const std::string& name, const std::string& path, const BatchSettings& given);

// InvalidArgument, naming the entry's number, from 1, and what is wrong with it; also where there
// is none. `folder`: the manifest's. `given` goes before what the manifest says, but for its out.
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
