// A textured wall seen by a camera that moves sideways, and a square that moves on its own in front
// of it: the smallest drive that has an answer.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "vision/frame/frame.h"

namespace egosieve::vision {

class MovingSquare {
 public:
  static constexpr int kWidth = 240;
  static constexpr int kHeight = 160;
  static constexpr int kSide = 56;

  MovingSquare() {
    cv::RNG random(20);
    wall_ = Texture(random, cv::Size(kWidth + 200, kHeight), cv::Scalar(150, 140, 120));
    square_ = Texture(random, cv::Size(kSide, kSide), cv::Scalar(40, 60, 200));
  }

  // The wall moves left by 3 pixels a frame, the square right by 4.
  Frame At(int64_t index) const {
    Frame frame;
    frame.index = index;
    frame.time_seconds = 0.1 * static_cast<double>(index);
    frame.image = wall_(cv::Rect(static_cast<int>(3 * index), 0, kWidth, kHeight)).clone();
    square_.copyTo(frame.image(Square(index)));
    return frame;
  }

  cv::Rect Square(int64_t index) const {
    return cv::Rect(30 + static_cast<int>(4 * index), 50, kSide, kSide);
  }

 private:
  static cv::Mat Texture(cv::RNG& random, cv::Size size, const cv::Scalar& colour) {
    cv::Mat noise(size, CV_8UC3), fine, coarse;
    random.fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(noise, fine, cv::Size(), 1.2);
    cv::GaussianBlur(noise, coarse, cv::Size(), 5.0);
    cv::Mat mixed;
    cv::addWeighted(fine, 1.5, coarse, 2.0, -320.0, mixed);
    cv::Mat tint(size, CV_8UC3, colour), texture;
    cv::addWeighted(mixed, 0.45, tint, 0.75, 0.0, texture);
    return texture;
  }

  cv::Mat wall_, square_;
};

}  // namespace egosieve::vision
