// A page of all drives of a batch: state, exit code, frames, and links to the results.
#ifndef EGOSIEVE_TOOLS_BATCH_INDEX_PAGE_H_
#define EGOSIEVE_TOOLS_BATCH_INDEX_PAGE_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tools/batch/drive_job.h"
#include "tools/batch/manifest.h"

namespace egosieve::tools {

// batch.html in the common parent folder of all run folders.
std::string DefaultIndexPath(const std::vector<BatchEntry>& entries);

// AlreadyExists if `path` is a file that no batch has written.
absl::Status CheckIndexPath(const std::string& path);

// The page's HTML. Links are relative to the folder of `path` and lead to existing files. While
// drives are running, the page reloads itself.
std::string IndexPage(const std::string& path, const std::vector<BatchEntry>& entries,
                      const std::vector<DriveOutcome>& outcomes);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_INDEX_PAGE_H_
