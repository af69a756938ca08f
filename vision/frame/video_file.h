// Videos and streams, decoded by FFmpeg.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {

// Frames of a video, decoded by FFmpeg. InvalidArgument for a file that is not a video or delivers
// no frame.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenVideoFile(const std::string& path,
                                                           const FrameSourceOptions& options);

// The longest time that a stream may take to open or be silent.
inline constexpr int kStreamTimeoutSeconds = 10;

// A stream of frames, in which the caller must not seek (live_stream.h). Nothing is read yet.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenStreamAsVideo(const std::string& address);

}  // namespace egosieve::vision
