// Videos and streams, decoded by FFmpeg.
//
// A stream brings the frames of a camera or another sender as they arrive, from an address that
// FFmpeg opens: rtsp://, http://, tcp://, udp:// and others. Delivered frames are not kept, except
// for the last: SeekTo goes forward by dropping frames, or back to the last delivered frame. A
// stream has no length and no picture files.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {

// Frames of a video. InvalidArgument for a file that is not a video or delivers no frame.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenVideoFile(const std::string& path,
                                                           const FrameSourceOptions& options);

// Checks that a video just written is on the disk with all of its frames, since cv::VideoWriter
// does not report failed writes. Syncs the file and reads its index, which is written last.
// ResourceExhausted, naming the path, if it is not complete.
absl::Status CheckWrittenVideo(const std::string& path, int64_t frames);

// Whether the input is a stream's address: a scheme followed by "://".
bool IsStreamAddress(const std::string& input);

// The address without user name and password.
std::string WithoutCredentials(const std::string& address);

// Waits for the first frame. InvalidArgument if the stream cannot be opened or delivers no frame
// within ten seconds. A stream that delivers nothing for that long has ended.
absl::StatusOr<std::unique_ptr<FrameSource>> OpenLiveStream(const std::string& address);

}  // namespace egosieve::vision
