#include "vision/labelling/among_movers.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace egosieve::vision {

AmongMovers::AmongMovers(const std::vector<cv::Point2f>& moving, cv::Size picture, int cell)
    : cell_(cell) {
  const double reach = kReach * std::max(picture.width, picture.height) / cell;
  reach_ = std::max(1, static_cast<int>(std::lround(reach)));
  cv::Mat1b has_mover = cv::Mat1b::zeros(picture.height / cell + 1, picture.width / cell + 1);
  for (const cv::Point2f& place : moving) has_mover(CellOf(place)) = 1;
  cv::integral(has_mover, count_, CV_32S);
}

cv::Point AmongMovers::CellOf(cv::Point2f place) const {
  return {static_cast<int>(place.x) / cell_, static_cast<int>(place.y) / cell_};
}

bool AmongMovers::Has(cv::Point2f place) const {
  const cv::Point c = CellOf(place);
  const cv::Rect all(0, 0, count_.cols - 1, count_.rows - 1);
  const auto any = [&](int x, int y, int width, int height) {
    const cv::Rect r = cv::Rect(c.x + x, c.y + y, width, height) & all;
    return count_(r.br()) + count_(r.tl()) >
           count_(r.y, r.x + r.width) + count_(r.y + r.height, r.x);
  };
  return any(1, 0, reach_, reach_ + 1) && any(-reach_, 1, reach_ + 1, reach_) &&
         any(-reach_, -reach_, reach_, reach_ + 1) && any(0, -reach_, reach_ + 1, reach_);
}

}  // namespace egosieve::vision
