// The drives in a folder, or those that match a glob: each video, and each folder with pictures or
// videos in it, or in its subfolder frames/ or images/. Everything else is left out.
#ifndef EGOSIEVE_TOOLS_BATCH_FOUND_DRIVES_H_
#define EGOSIEVE_TOOLS_BATCH_FOUND_DRIVES_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::tools {

struct FoundDrives {
  // The name of the file without its extension or of the folder, and the path for segment; in
  // natural order.
  std::vector<std::pair<std::string, std::string>> drives;
  std::vector<std::string> left_out;  // names
};

// `input`: a folder, a glob or a video. NotFound if nothing is there. InvalidArgument if it has no
// drive, or if a folder holds the pictures of one drive.
absl::StatusOr<FoundDrives> FindDrives(const std::string& input);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_FOUND_DRIVES_H_
