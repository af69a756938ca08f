// Connected regions of masks and of pictures of numbers.
#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <vector>

namespace egosieve::vision {

struct Piece {
  cv::Mat1b pixels;
  int area = 0;
};

// 8-connected pieces, the largest first; equal ones in the order of their first pixels.
std::vector<Piece> PiecesOf(const cv::Mat1b& region);

// The count of pixels of each number but 0 within the region.
std::map<uint16_t, int> CountNumbers(const cv::Mat1w& numbers, const cv::Mat1b& region);

// The number of the nearest pixel that has one, for each pixel; 0 where none has. distance: from it.
cv::Mat1w NearestNumbers(const cv::Mat1w& numbers, cv::Mat1f& distance);

// Gives every pixel of `region` without a number that of the nearest numbered pixel of `region`.
void FillNearest(const cv::Mat1b& region, cv::Mat1w& numbers);

// The next number from 1 to 65535, and then again from 1, that is not taken. next: where to begin;
// the number after it.
template <typename IsTaken>
uint16_t NextNumber(const IsTaken& is_taken, int& next) {
  constexpr int kNumbers = 65535;
  while (is_taken(next)) next = next % kNumbers + 1;
  const auto number = static_cast<uint16_t>(next);
  next = next % kNumbers + 1;
  return number;
}

// The pixels around a region, up to `reach` away.
cv::Mat1b RingAround(const cv::Mat1b& region, int reach);

}  // namespace egosieve::vision
