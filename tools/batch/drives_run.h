// Runs the tasks of a batch on this machine, several at the same time.
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVES_RUN_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVES_RUN_H_

#include <string>
#include <vector>

#include "tools/batch/plan.h"
#include "tools/batch/status.h"

namespace egosieve::tools {

// `jobs` tasks at the same time, which share the threads; a drive goes to its end before the next
// begins, as far as its tasks leave programs free. Ends early if interrupted. A failing task ends
// its drive and no other. Each task is a line on stderr, and the page (status.h) is written anew; if
// it cannot be written, that is a warning at the end. program: egosieve. Returns how the drives are.
std::vector<DriveStatus> RunDrives(const BatchPlan& plan, const std::string& program, int jobs);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVES_RUN_H_
