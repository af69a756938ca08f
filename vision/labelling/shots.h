// The shots of a recording: what lies between two cuts. Each may have a camera of its own.
//
// A cut lies between two pictures that show different scenes (one_scene.h), if the scene is the same
// in the pictures before it, and in kStays pictures after it, none of which is again of the scene
// before. So a picture with a flash, a damaged one, or a quick pan is no cut. Blank pictures, as
// where one scene fades out and another in, are left out. A picture of another size begins no shot.
// Pictures are reduced to 320 pixels.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::vision {

// Indices of the first frame of each shot; the first is `begin`. Reads from `begin`, which is the
// source's next frame, to frame end - 1; end < 0: to the source's end. Unreadable frames are skipped;
// errors are the source's.
absl::StatusOr<std::vector<int64_t>> FindShots(FrameSource& source, int64_t begin, int64_t end);

}  // namespace egosieve::vision
