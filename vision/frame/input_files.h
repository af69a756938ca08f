// The pictures or videos that a folder or a glob names.
#ifndef EGOSIEVE_VISION_FRAME_INPUT_FILES_H_
#define EGOSIEVE_VISION_FRAME_INPUT_FILES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::vision {

// Pictures, or videos where there are no pictures, in natural order.
struct InputFiles {
  std::vector<std::string> paths;
  bool are_videos = false;
};

// True for the file name extensions of videos, in upper or lower case.
bool HasVideoExtension(const std::string& path);

// The files in the folder itself, or those in the folders below it if it has neither pictures nor
// videos. Hidden files and folders are skipped. InvalidArgument if there are none.
absl::StatusOr<InputFiles> FilesOfFolder(const std::string& folder);

// NotFound if nothing matches; InvalidArgument if no match is a picture or a video.
absl::StatusOr<InputFiles> FilesOfGlob(const std::string& pattern);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_INPUT_FILES_H_
