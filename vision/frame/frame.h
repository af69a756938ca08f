// One picture of a video, in the form that the whole library reads.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace egosieve::vision {

// Copies share the pixels, so treat `image` as immutable once the frame has been passed on.
struct Frame {
  int64_t index = 0;          // in the input, from 0; damaged frames are counted
  double time_seconds = 0.0;  // from the stream; index / nominal rate without a clock
  cv::Mat image;              // CV_8UC3, B G R; grey is replicated into all three
  bool is_grey = false;       // the input had one channel
};

}  // namespace egosieve::vision
