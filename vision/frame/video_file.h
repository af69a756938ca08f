// Videos and streams, decoded by FFmpeg.
#ifndef EGOSIEVE_VISION_FRAME_VIDEO_FILE_H_
#define EGOSIEVE_VISION_FRAME_VIDEO_FILE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {

// Frames of a video, decoded by FFmpeg. InvalidArgument for a file that is no video or delivers no
// frame.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenVideoFile(const std::string& path,
                                                           const FrameSourceOptions& options);

// How long a stream may take to open, and be silent.
inline constexpr int kStreamTimeoutSeconds = 10;

// A stream of frames that must not be sought in (live_stream.h). Nothing is read yet.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenStreamAsVideo(const std::string& address);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_VIDEO_FILE_H_
