// The data computed once from a single frame.
#pragma once

#include <opencv2/core.hpp>

#include "vision/frame/frame.h"

namespace egosieve::vision {

// Shared by pointer and immutable to its users. A labeller may derive what else it needs.
struct ExtractedFrame {
  Frame frame;
  cv::Mat grey;  // CV_8UC1, equalised
  double equalization_milliseconds = 0.0;
};

}  // namespace egosieve::vision
