// Keeps OpenCV and FFmpeg from writing to stderr, since our own statuses report their errors. The
// environment variables OPENCV_LOG_LEVEL and OPENCV_FFMPEG_LOGLEVEL have precedence. Cheap after
// the first call; thread-safe.
#pragma once

namespace egosieve::vision {

void QuietLibraries();

}  // namespace egosieve::vision
