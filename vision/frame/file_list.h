// Reads lists of pictures and of their times.
//
//   list    a file .txt or .csv; a line "NAME", "TIME NAME", "TIME,NAME" or "NAME,TIME" for each
//           picture, as TUM's rgb.txt and EuRoC's data.csv have them. Names are absolute, or
//           relative to the list's folder or to data/ in it, and may have spaces and commas: a
//           line that is the name of a file is a name. Fields are separated by commas, semicolons,
//           tabs or spaces, and may be quoted. Of several fields that name files, as in TUM's
//           associations, the first counts that is no depth map or mask (SideKind in
//           input_files.h); its time is the field before it, else the one behind it, or the column
//           with "time" in its name
//   times   a file with one time per line, in the order of the pictures, as KITTI's times.txt and
//           timestamps.txt have them
//   time    seconds; nanoseconds where it has 18 digits or more and no point;
//           2011-09-26 13:02:25.59
//
// Empty lines, lines that begin with #, a byte order mark and a first line of column names are
// skipped.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/frame/input_files.h"

namespace egosieve::vision {

// Between two pictures of a drive; half of the steps are shorter.
inline constexpr double kLongestStepSeconds = 10.0;

// True for the file name extensions of lists.
bool HasListExtension(const std::string& path);

// InvalidArgument, naming the line, for a list without names or of depth maps alone, a missing
// file, a line of another form, times that are equal or do not ascend, and times whose steps are
// longer than kLongestStepSeconds: milliseconds, microseconds or nanoseconds.
absl::StatusOr<InputFiles> ReadFileList(const std::string& path);

// Reads `count` times. InvalidArgument likewise, and for another number of times.
absl::StatusOr<std::vector<double>> ReadTimes(const std::string& path, size_t count);

}  // namespace egosieve::vision
