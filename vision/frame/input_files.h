// The pictures or videos that a folder or a glob names.
#ifndef EGOSIEVE_VISION_FRAME_INPUT_FILES_H_
#define EGOSIEVE_VISION_FRAME_INPUT_FILES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::vision {

// Pictures, or where there is none videos, in natural order.
struct InputFiles {
  std::vector<std::string> paths;
  bool are_videos = false;
};

// True for the file name extensions of videos, whatever their case.
bool HasVideoExtension(const std::string& path);

// The files in the folder itself; where it has neither pictures nor videos, those in the folders
// below it. Hidden files and folders do not count. InvalidArgument where there are none.
absl::StatusOr<InputFiles> FilesOfFolder(const std::string& folder);

// NotFound where nothing matches; InvalidArgument where no match is a picture or a video.
absl::StatusOr<InputFiles> FilesOfGlob(const std::string& pattern);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_INPUT_FILES_H_
