// Takes over the maps of a later piece of a drive. Pieces differ in their first frame, and so in
// their first picture; each line names the device of its map.
#ifndef EGOSIEVE_TOOLS_MERGE_TAKEN_MAPS_H_
#define EGOSIEVE_TOOLS_MERGE_TAKEN_MAPS_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tools/cli/progress.h"
#include "tools/run_folder/run_description.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// FailedPrecondition unless the run in `source` is another piece of the drive that `description` is
// of.
absl::Status CheckPiece(const RunDescription& description, const std::string& source);

// Links the maps that `target`, whose description is `description`, lacks, and takes over their
// lines; returns the number of frames whose maps were linked. Unavailable if the folders lie on
// different file systems; Cancelled if interrupted.
absl::StatusOr<int64_t> TakeMaps(const RunFolder& target, const RunDescription& description,
                                 const std::string& source, const ProgressFlag& flag);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MERGE_TAKEN_MAPS_H_
