// A drive's files beside its run folder, and the book of what is done after segment: both batches
// on this machine and tasks of engines (plan.h) read and write it.
//
//   egosieve_logs/OUT.log            the output of its programs
//   egosieve_logs/OUT.tasks/COMMAND  the note of a finished step: the end of the run that it was
//                                    done on, and its flags
//   OUT.masks                        the masks
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVE_FILES_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVE_FILES_H_

#include <string>

#include "absl/status/status.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

std::string LogPath(const BatchEntry& entry);
std::string TaskNotesPath(const BatchEntry& entry);
std::string MasksPath(const BatchEntry& entry);

// Whether the step is noted for the run that ended at `finished_utc`, and its product is there.
bool IsStepDone(const BatchEntry& entry, const BatchStep& step, const std::string& finished_utc);
absl::Status NoteStepDone(const BatchEntry& entry, const BatchStep& step,
                          const std::string& finished_utc);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVE_FILES_H_
