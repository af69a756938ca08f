#include "bench/vision/textured_pair.h"

#include <opencv2/imgproc.hpp>
#include <random>

namespace egosieve::vision {
namespace {

constexpr int kWidth = 1242, kHeight = 375;

cv::Mat Wall() {
  std::mt19937_64 random(7);
  cv::Mat sum = cv::Mat::zeros(kHeight, kWidth, CV_32F);
  for (const int scale : {2, 4, 9, 20}) {
    cv::Mat noise(kHeight / scale + 2, kWidth / scale + 2, CV_8U);
    for (int i = 0; i < noise.rows; ++i) {
      for (int j = 0; j < noise.cols; ++j) noise.at<uint8_t>(i, j) = static_cast<uint8_t>(random());
    }
    cv::Mat large;
    cv::resize(noise, large, sum.size(), 0, 0, cv::INTER_CUBIC);
    cv::accumulateWeighted(large, sum, 0.3);
  }
  cv::Mat wall;
  sum.convertTo(wall, CV_8U);
  return wall;
}

TexturedPair Make() {
  TexturedPair pair;
  pair.first = Wall();
  pair.homography = cv::Matx33d(1.01, 0.002, -9.0, -0.001, 1.012, -3.0, 1e-6, 0, 1);
  cv::warpPerspective(pair.first, pair.second, cv::Mat(pair.homography), pair.first.size(),
                      cv::INTER_LINEAR, cv::BORDER_REFLECT);
  return pair;
}

}  // namespace

const TexturedPair& BenchmarkPair() {
  static const TexturedPair pair = Make();
  return pair;
}

}  // namespace egosieve::vision
