// Reads lists of pictures and of their times.
//
//   list    a file .txt or .csv; a line "NAME", "TIME NAME", "TIME,NAME" or "NAME,TIME" for each
//           picture, as TUM's rgb.txt and EuRoC's data.csv have them. Names are absolute, or
//           relative to the list's folder or to data/ in it
//   times   a file with one time per line, in the order of the pictures, as KITTI's times.txt and
//           timestamps.txt have them
//   time    seconds; nanoseconds where it has 18 digits or more and no point;
//           2011-09-26 13:02:25.59
//
// Empty lines, lines that begin with #, and a first line of column names are skipped.
#ifndef EGOSIEVE_VISION_FRAME_FILE_LIST_H_
#define EGOSIEVE_VISION_FRAME_FILE_LIST_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace egosieve::vision {

struct FileList {
  std::vector<std::string> paths;
  std::vector<double> times_seconds;  // one per path; empty if the list has none
};

// True for the file name extensions of lists.
bool HasListExtension(const std::string& path);

// InvalidArgument, naming the line, for a list without names, a missing file, a line of another
// form, and times that do not ascend.
absl::StatusOr<FileList> ReadFileList(const std::string& path);

// Reads `count` times. InvalidArgument likewise, and for another number of times.
absl::StatusOr<std::vector<double>> ReadTimes(const std::string& path, size_t count);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_FILE_LIST_H_
