// A page of all drives of a batch: state, exit code, frames, and links to what was made.
#ifndef EGOSIEVE_TOOLS_BATCH_INDEX_PAGE_H_
#define EGOSIEVE_TOOLS_BATCH_INDEX_PAGE_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tools/batch/drive_job.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

// batch.html in the folder that all run folders share.
std::string DefaultIndexPath(const std::vector<BatchEntry>& entries);

// AlreadyExists where `path` is a file that no batch wrote.
absl::Status CheckIndexPath(const std::string& path);

// The page's HTML. Links are relative to the folder of `path`, to what is there. While drives are
// running, the page loads itself anew.
std::string IndexPage(const std::string& path, const std::vector<BatchEntry>& entries,
                      const std::vector<DriveOutcome>& outcomes);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_INDEX_PAGE_H_
