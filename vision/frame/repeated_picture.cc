#include "vision/frame/repeated_picture.h"

#include <cstring>
#include <utility>

namespace egosieve::vision {

bool SamePixels(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  for (int row = 0; row < a.rows; ++row) {
    if (std::memcmp(a.ptr(row), b.ptr(row), a.cols * a.elemSize()) != 0) return false;
  }
  return true;
}

void AppendPicture(Frame frame, std::deque<Frame>& frames) {
  if (!frames.empty() && SamePixels(frames.back().image, frame.image)) {
    frame.time_seconds = frames.back().time_seconds;
    frames.back() = std::move(frame);
  } else {
    frames.push_back(std::move(frame));
  }
}

}  // namespace egosieve::vision
