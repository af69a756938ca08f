// The drives in a folder, or those that a glob names.
//
// In a folder every video is a drive, and every folder that holds pictures or videos, or has a
// folder frames/ or images/ that does; a glob's matches likewise. What is none of these is left out
// and reported.
#ifndef EGOSIEVE_TOOLS_BATCH_FOUND_DRIVES_H_
#define EGOSIEVE_TOOLS_BATCH_FOUND_DRIVES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::tools {

struct FoundDrive {
  std::string name;  // of the file without its extension, or of the folder
  std::string path;  // what segment is given
};

struct FoundDrives {
  std::vector<FoundDrive> drives;     // in natural order
  std::vector<std::string> left_out;  // names
};

// `input`: a folder, a glob or a video. NotFound where there is nothing; InvalidArgument where none
// of it is a drive, where a folder holds the pictures of one, and where two have one name.
absl::StatusOr<FoundDrives> FindDrives(const std::string& input);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_FOUND_DRIVES_H_
