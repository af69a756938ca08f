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
  cv::Rect box;
};

// 8-connected pieces, the largest first; equal ones in the order of their first pixels.
std::vector<Piece> PiecesOf(const cv::Mat1b& region);

// The count of pixels of each number but 0 within the region.
std::map<uint16_t, int> CountNumbers(const cv::Mat1w& numbers, const cv::Mat1b& region);

// Gives every pixel of `region` without a number that of the nearest numbered pixel of `region`.
void FillNearest(const cv::Mat1b& region, cv::Mat1w& numbers);

// The pixels around a region, up to `reach` away.
cv::Mat1b RingAround(const cv::Mat1b& region, int reach);

}  // namespace egosieve::vision
