// A picture with texture everywhere, for tests of features and flow.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

namespace egosieve::vision::testing {

// Smooth noise at several scales, CV_8UC1.
inline cv::Mat TexturedImage(int width, int height, uint64_t seed) {
  std::mt19937_64 random(seed);
  cv::Mat sum = cv::Mat::zeros(height, width, CV_32F);
  for (const int scale : {3, 7, 16}) {
    cv::Mat noise(height / scale + 2, width / scale + 2, CV_8U);
    for (int i = 0; i < noise.rows; ++i) {
      for (int j = 0; j < noise.cols; ++j) noise.at<uint8_t>(i, j) = static_cast<uint8_t>(random());
    }
    cv::Mat large;
    cv::resize(noise, large, sum.size(), 0, 0, cv::INTER_CUBIC);
    cv::accumulate(large, sum);
  }
  cv::Mat image;
  sum.convertTo(image, CV_8U, 1.0 / 3);
  return image;
}

}  // namespace egosieve::vision::testing
