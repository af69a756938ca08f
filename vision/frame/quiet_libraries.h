// Keeps OpenCV and FFmpeg from writing to stderr: what they would say is in our own statuses. A
// user who sets OPENCV_LOG_LEVEL or OPENCV_FFMPEG_LOGLEVEL gets what these ask for. Cheap after the
// first call; thread-safe.
#ifndef EGOSIEVE_VISION_FRAME_QUIET_LIBRARIES_H_
#define EGOSIEVE_VISION_FRAME_QUIET_LIBRARIES_H_

namespace egosieve::vision {

void QuietLibraries();

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_QUIET_LIBRARIES_H_
