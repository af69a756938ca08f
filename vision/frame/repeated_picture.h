// Pictures that a recording repeats byte for byte.
#pragma once

#include <deque>
#include <opencv2/core.hpp>

#include "vision/frame/frame.h"

namespace egosieve::vision {

// Whether sizes, types and bytes are the same.
bool SamePixels(const cv::Mat& a, const cv::Mat& b);

// Appends `frame`. A repeat of the last picture takes its place, at the time of the first of them.
void AppendPicture(Frame frame, std::deque<Frame>& frames);

}  // namespace egosieve::vision
