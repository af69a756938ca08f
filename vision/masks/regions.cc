#include "vision/masks/regions.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace egosieve::vision {

std::vector<Piece> PiecesOf(const cv::Mat1b& region) {
  cv::Mat1i labels;
  cv::Mat stats, centres;
  const int count = cv::connectedComponentsWithStats(region, labels, stats, centres, 8, CV_32S);
  std::vector<Piece> pieces;
  for (int i = 1; i < count; ++i) {
    pieces.push_back({labels == i, stats.at<int>(i, cv::CC_STAT_AREA)});
  }
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const Piece& a, const Piece& b) { return a.area > b.area; });
  return pieces;
}

std::map<uint16_t, int> CountNumbers(const cv::Mat1w& numbers, const cv::Mat1b& region) {
  std::map<uint16_t, int> counts;
  int* count = nullptr;  // that of the previous pixel's number
  uint16_t before = 0;
  for (int y = 0; y < region.rows; ++y) {
    for (int x = 0; x < region.cols; ++x) {
      const uint16_t number = numbers(y, x);
      if (number == 0 || region(y, x) == 0) continue;
      if (number != before || count == nullptr) count = &counts[number];
      before = number;
      ++*count;
    }
  }
  return counts;
}

cv::Mat1w NearestNumbers(const cv::Mat1w& numbers, cv::Mat1f& distance) {
  cv::Mat1w nearest = cv::Mat1w::zeros(numbers.size());
  if (cv::countNonZero(numbers) == 0) return nearest;
  cv::Mat1i labels;
  cv::distanceTransform(numbers == 0, distance, labels, cv::DIST_L2, cv::DIST_MASK_5,
                        cv::DIST_LABEL_PIXEL);
  std::vector<uint16_t> number_of(numbers.total() + 1, 0);
  for (int y = 0; y < numbers.rows; ++y) {
    for (int x = 0; x < numbers.cols; ++x) {
      if (numbers(y, x) != 0) number_of[labels(y, x)] = numbers(y, x);
    }
  }
  std::transform(labels.begin(), labels.end(), nearest.begin(),
                 [&](int label) { return number_of[label]; });
  return nearest;
}

void FillNearest(const cv::Mat1b& region, cv::Mat1w& numbers) {
  cv::Mat1w of_region = cv::Mat1w::zeros(numbers.size());
  numbers.copyTo(of_region, region);
  cv::Mat1f distance;
  NearestNumbers(of_region, distance).copyTo(numbers, (numbers == 0) & (region != 0));
}

cv::Mat1b RingAround(const cv::Mat1b& region, int reach) {
  cv::Mat1b ring;
  const int side = 2 * reach + 1;
  cv::dilate(region, ring, cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  ring.setTo(0, region);
  return ring;
}

}  // namespace egosieve::vision
