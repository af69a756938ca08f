// The drives in a folder, or those that match a glob.
//
// In a folder, each video is a drive, and so is each folder with pictures or videos in it, or in
// its subfolder frames/ or images/. The same holds for the matches of a glob. Everything else is
// left out and reported.
#ifndef EGOSIEVE_TOOLS_BATCH_FOUND_DRIVES_H_
#define EGOSIEVE_TOOLS_BATCH_FOUND_DRIVES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::tools {

struct FoundDrive {
  std::string name;  // of the file without its extension, or of the folder
  std::string path;  // the path for segment
};

struct FoundDrives {
  std::vector<FoundDrive> drives;     // in natural order
  std::vector<std::string> left_out;  // names
};

// `input`: a folder, a glob or a video. NotFound if nothing is there. InvalidArgument if it has no
// drive, if a folder holds the pictures of one drive, or if two drives have the same name.
absl::StatusOr<FoundDrives> FindDrives(const std::string& input);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_FOUND_DRIVES_H_
