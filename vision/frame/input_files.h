// The pictures or videos that a folder or a glob names.
//
// Left out, and told: masks, depth maps and labels beside pictures, by the words of their names;
// NAME.png or NAME.jpg.png beside NAME.jpg; smaller copies of the pictures of a folder X in a
// folder X_2 beside it; pictures in formats that are not read; videos beside pictures. Hidden files
// and folders are skipped.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::vision {

// Pictures, or videos where there are no pictures, in natural order.
struct InputFiles {
  std::vector<std::string> paths;
  bool are_videos = false;
  std::vector<double> times_seconds;  // one per path; empty: none are known
  std::vector<std::string> remarks;   // on what is left out, one sentence each
};

// True for the file name extensions of videos, in upper or lower case.
bool HasVideoExtension(const std::string& path);

// What the words of a picture's name or of its folders' names say it is, "masks", "depth maps" or
// "labels"; empty for the pictures of a camera. path: relative to the input.
std::string SideKind(const std::string& path);

// The files in the folder itself, or those in the folders below it if it has neither pictures nor
// videos; links to folders are followed. InvalidArgument if there are none, or if they are of
// several cameras: folders whose files have the same numbers, or two series of names in one folder.
absl::StatusOr<InputFiles> FilesOfFolder(const std::string& folder);

// NotFound if nothing matches; InvalidArgument if no match is a picture or a video.
absl::StatusOr<InputFiles> FilesOfGlob(const std::string& pattern);

}  // namespace egosieve::vision
