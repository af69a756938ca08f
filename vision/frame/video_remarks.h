// Remarks on videos that are not read as they were recorded or meant to be seen.
//
//   interlaced     each frame holds two half pictures of different times: moving objects have
//                  combed edges
//   HDR            brightness coded for very bright screens (PQ, HLG) is read as ordinary
//                  brightness: pictures have little contrast
//
//   gaps           chapters of one drive with missing time between them, or in an order that
//                  differs from their times: by the creation times of the files, where all have
//                  one and a gap is longer than kGapSeconds
//
// Videos with only ten or twelve bits per colour are read correctly, rounded to eight.
#pragma once

#include <string>
#include <vector>

namespace egosieve::vision {

// Creation times are in whole seconds, and cameras need a moment to begin a file.
inline constexpr double kGapSeconds = 3.0;

// Remarks on a video, or on the chapters of a drive in their order, which are assumed to differ
// only in their times. One sentence each, with the remedy; none for files that are not videos. They
// rely on the metadata of the files.
std::vector<std::string> RemarksOnVideos(const std::vector<std::string>& paths);

}  // namespace egosieve::vision
