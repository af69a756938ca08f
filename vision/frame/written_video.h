// Checks that a video just written is on the disk with all of its frames, since cv::VideoWriter
// does not report failed writes. Syncs the file and reads its index, which is written last.
// ResourceExhausted, naming the path, if it is not complete.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"

namespace egosieve::vision {

absl::Status CheckWrittenVideo(const std::string& path, int64_t frames);

}  // namespace egosieve::vision
