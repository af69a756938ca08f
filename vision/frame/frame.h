// One picture of a video, in the one form that the rest of the library reads.
#ifndef EGOSIEVE_VISION_FRAME_FRAME_H_
#define EGOSIEVE_VISION_FRAME_FRAME_H_

#include <cstdint>
#include <opencv2/core.hpp>

namespace egosieve::vision {

// Copies share the pixels: treat `image` as immutable once the frame has been handed on.
struct Frame {
  int64_t index = 0;          // in the input, from 0; damaged frames keep their place in the count
  double time_seconds = 0.0;  // from the stream; index / nominal rate where there is no clock
  cv::Mat image;              // CV_8UC3, B G R; a grey picture is replicated into the three
  bool is_grey = false;       // the input had one channel
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_FRAME_FRAME_H_
