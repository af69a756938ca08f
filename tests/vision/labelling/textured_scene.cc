#include "tests/vision/labelling/textured_scene.h"

#include <opencv2/imgproc.hpp>
#include <random>

#include "tests/testing/status.h"
#include "vision/segmentation/labeller_factory.h"

namespace egosieve::vision {

cv::Mat Texture(int width, int height, uint64_t seed) {
  std::mt19937_64 engine(seed);
  cv::Mat sum = cv::Mat::zeros(height, width, CV_32FC3);
  for (const int scale : {2, 5, 12}) {
    cv::Mat noise(height / scale + 2, width / scale + 2, CV_8UC3);
    for (int i = 0; i < noise.rows; ++i) {
      for (int j = 0; j < noise.cols; ++j) {
        for (int c = 0; c < 3; ++c) noise.at<cv::Vec3b>(i, j)[c] = static_cast<uint8_t>(engine());
      }
    }
    cv::Mat large;
    cv::resize(noise, large, cv::Size(width, height), 0, 0, cv::INTER_CUBIC);
    cv::Mat part;
    large.convertTo(part, CV_32FC3, 1.0 / 3);
    sum += part;
  }
  cv::Mat image;
  sum.convertTo(image, CV_8UC3);
  return image;
}

Frame WallFrame(int64_t index) {
  static const cv::Mat wall = Texture(3 * kWidth, kHeight, 5), square = Texture(60, 60, 6);
  Frame frame{.index = index,
              .time_seconds = 0.1 * static_cast<double>(index),
              .image = wall(cv::Rect(3 * static_cast<int>(index), 0, kWidth, kHeight)).clone()};
  square.copyTo(frame.image(cv::Rect(30 + 4 * static_cast<int>(index), 50, 60, 60)));
  return frame;
}

cv::Mat WallMask(int64_t index) {
  cv::Mat mask = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  mask(cv::Rect(30 + 4 * static_cast<int>(index), 50, 60, 60)).setTo(255);
  return mask;
}

Frame FrameOf(int64_t index, const cv::Mat& image) { return {.index = index, .image = image}; }

std::vector<FrameLabellerOptions> EveryKindOfOptions() {
  const FrameLabellerOptions known{.focal_ratio = 1.0};
  return {FrameLabellerOptions(), known, FrameLabellerOptions::Paper()};
}

std::unique_ptr<FrameLabeller> MakeLabeller(const FrameLabellerOptions& options) {
  return Value(MakeFrameLabeller(options));
}

}  // namespace egosieve::vision
