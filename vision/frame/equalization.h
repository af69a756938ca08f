// Luminance equalisation: removes global changes of light and brightens dark areas ("histogram
// filter", paper, section III).
//
//   kGlobal   Y' = 255 (C(Y) - C_min) / (N - C_min), C the cumulative histogram of the frame
//   kClahe    the same in tiles, with the histogram's slope clipped (Zuiderveld, 1994)
//
// The colour is kept: Y' replaces the luminance of Y Cr Cb.
#pragma once

#include <opencv2/core.hpp>

namespace egosieve::vision {

enum class Equalization { kNone, kGlobal, kClahe };

// image: CV_8UC1 or CV_8UC3 (B G R). Returns a new image of the same type, or the image itself for
// kNone.
cv::Mat EqualizeLuminance(const cv::Mat& image, Equalization method);

// The equalised luminance, CV_8UC1, of a CV_8UC3 image.
cv::Mat EqualizedGrey(const cv::Mat& image, Equalization method);

}  // namespace egosieve::vision
