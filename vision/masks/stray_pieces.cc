#include "vision/masks/stray_pieces.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace egosieve::vision {
namespace {

constexpr double kApart = 0.5;       // (MP1)
constexpr double kLeastStray = 0.1;  // of the largest piece of a number; smaller pieces are errors

// The distance between two boxes, pixels.
double Gap(const cv::Rect& a, const cv::Rect& b) {
  const int x = std::max({0, b.x - a.br().x, a.x - b.br().x});
  const int y = std::max({0, b.y - a.br().y, a.y - b.br().y});
  return std::hypot(x, y);
}

}  // namespace

RegionLabels::RegionLabels(const cv::Mat1b& mask) {
  cv::connectedComponents(mask, labels_, 8, CV_32S);
}

int RegionLabels::LabelOf(const Piece& piece) const {
  cv::Point place;
  cv::minMaxLoc(piece.pixels, nullptr, nullptr, nullptr, &place);
  return labels_(place);
}

bool RegionLabels::LieApart(const Piece& a, const Piece& b) const {
  return Gap(a.box, b.box) > kApart * std::sqrt(std::min(a.area, b.area)) &&
         LabelOf(a) != LabelOf(b);
}

void DropStrays(const RegionLabels& regions, int min_pixels, cv::Mat1w& numbers) {
  for (const auto& [number, count] : CountNumbers(numbers, numbers != 0)) {
    const std::vector<Piece> pieces = PiecesOf(numbers == number);
    const Piece& largest = pieces.front();
    for (const Piece& piece : pieces) {
      if (piece.area < kLeastStray * largest.area || 2 * piece.area < min_pixels ||
          regions.LieApart(piece, largest)) {
        numbers.setTo(0, piece.pixels);
      }
    }
  }
}

}  // namespace egosieve::vision
