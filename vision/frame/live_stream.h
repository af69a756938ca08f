// Frames of a camera or another sender as they come, from an address that FFmpeg opens: rtsp://,
// http://, tcp://, udp:// and others.
//
// What has been delivered is gone: SeekTo goes forward, by frames that are dropped, or back to the
// last frame that was delivered. A stream has no length, and its picture files are none.
#ifndef EGOSIEVE_VISION_FRAME_LIVE_STREAM_H_
#define EGOSIEVE_VISION_FRAME_LIVE_STREAM_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {

// Whether the input is an address, with a scheme and "://".
bool IsStreamAddress(const std::string& input);

// Waits for its first frame. InvalidArgument where it cannot be opened or delivers none within
// kStreamTimeoutSeconds (video_file.h); a stream that falls silent for as long has ended.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenLiveStream(const std::string& address);

// Without user name and password.
std::string WithoutCredentials(const std::string& address);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_LIVE_STREAM_H_
