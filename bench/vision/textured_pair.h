// Two pictures of one textured wall from slightly different places, 1242 x 375: corners and blobs
// of many sizes, enough for 7000 features.
#pragma once

#include <opencv2/core.hpp>

namespace egosieve::vision {

struct TexturedPair {
  cv::Mat first, second;   // CV_8UC1
  cv::Matx33d homography;  // first to second, pixels
};

// The same pair at every call.
const TexturedPair& BenchmarkPair();

}  // namespace egosieve::vision
