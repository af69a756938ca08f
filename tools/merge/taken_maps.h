// Takes over the maps of another run folder: a copy of the run, or a later piece of its drive.
//
// Copies differ in path and device of the maps, which each line names; pieces differ in their first
// frame, and so in their first picture.
#ifndef EGOSIEVE_TOOLS_MERGE_TAKEN_MAPS_H_
#define EGOSIEVE_TOOLS_MERGE_TAKEN_MAPS_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "tools/cli/progress.h"
#include "tools/run_folder/run_description.h"
#include "tools/run_folder/run_folder.h"

namespace egosieve::tools {

// Whether the run in `source` is a piece rather than a copy of the run that `description` is of.
// FailedPrecondition if it is neither.
absl::StatusOr<bool> CheckSource(const RunDescription& description, const std::string& source);

// Copies the maps and lines that `target`, whose description is `description`, lacks; returns the
// number of frames whose maps were copied. Cancelled if interrupted.
absl::StatusOr<int64_t> TakeMaps(const RunFolder& target, const RunDescription& description,
                                 const std::string& source, const ProgressFlag& flag);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MERGE_TAKEN_MAPS_H_
