// Finds which frame of a video a picture is. Pictures taken from a video, for example every sixth
// frame, have neither its times nor its numbers, may be scaled, and were compressed again.
//
// A picture and a frame are compared as thumbnails of 64 x 36 grey pixels, mean 0 and length 1:
//
//   (VF1) s(a, b) = a . b            1 for the same picture, whatever its brightness and contrast
//   (VF2) frame of p = argmax_k s(p, k), the first of equals
//
// A picture counts as part of the video if s is kLeastAgreement or more.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {

inline constexpr double kLeastAgreement = 0.995;

// Gives the frame of each picture; -1 for a picture that cannot be read. Reads both sources to
// their end. after_frame is called for each frame of the video; returning false ends the search
// with Cancelled. InvalidArgument, naming the first such picture, if pictures match no frame.
absl::StatusOr<std::vector<int64_t>> FindInVideo(vision::FrameSource& pictures,
                                                 vision::FrameSource& video,
                                                 const std::function<bool()>& after_frame);

}  // namespace egosieve::tools
