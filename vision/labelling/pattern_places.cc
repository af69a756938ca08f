#include "vision/labelling/pattern_places.h"

#include <algorithm>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

namespace egosieve::vision {

PatternPlaces::PatternPlaces(const FixedPattern* pattern, const cv::Mat& grey) {
  if (pattern == nullptr) return;
  cv::Mat1b reduced = ReducedPicture(grey);
  // A picture reduced twice may differ by a row from one reduced once.
  const cv::Size off = reduced.size() - pattern->size();
  if (std::max(std::abs(off.width), std::abs(off.height)) > 1) return;
  if (reduced.size() != pattern->size()) {
    cv::resize(reduced, reduced, pattern->size(), 0.0, 0.0, cv::INTER_AREA);
  }
  agreeing_ = pattern->Agreeing(SmoothPicture(reduced));
  scale_ = static_cast<double>(reduced.cols) / grey.cols;
}

bool PatternPlaces::Contain(cv::Point2f place) const {
  if (agreeing_.empty()) return false;
  const int column = std::clamp(cvRound((place.x + 0.5) * scale_ - 0.5), 0, agreeing_.cols - 1);
  const int row = std::clamp(cvRound((place.y + 0.5) * scale_ - 0.5), 0, agreeing_.rows - 1);
  return agreeing_(row, column) != 0;
}

}  // namespace egosieve::vision
