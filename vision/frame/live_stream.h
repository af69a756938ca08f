// Frames of a camera or another sender as they arrive, from an address that FFmpeg opens: rtsp://,
// http://, tcp://, udp:// and others.
//
// Delivered frames are not kept, except for the last: SeekTo goes forward by dropping frames, or
// back to the last delivered frame. A stream has no length and no picture files.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {

// Whether the input is an address: a scheme followed by "://".
bool IsStreamAddress(const std::string& input);

// Waits for the first frame. InvalidArgument if the stream cannot be opened or delivers no frame
// within kStreamTimeoutSeconds (video_file.h). A stream that delivers nothing for that long has
// ended.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenLiveStream(const std::string& address);

// The address without user name and password.
std::string WithoutCredentials(const std::string& address);

}  // namespace egosieve::vision
