#include "bench/drive/opencv_work.h"

#include <chrono>
#include <ctime>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "kernels/base/status_macros.h"

namespace egosieve::bench {

absl::StatusOr<OpenCvSeconds> MeasureOpenCv(const Clip& clip, int64_t count) {
  constexpr int kStride = 5;
  const auto flow = cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM);
  OpenCvSeconds seconds;
  cv::Mat before;
  for (int64_t i = 0; i < count; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t processor_start = std::clock();
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat picture, clip.read(PictureOf(i, clip.size)));
    cv::Mat grey, displacement;
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    if (!before.empty()) {
      flow->calc(before, grey, displacement);
      std::vector<cv::Point2f> from, to;
      for (int y = kStride / 2; y < grey.rows; y += kStride) {
        for (int x = kStride / 2; x < grey.cols; x += kStride) {
          from.emplace_back(static_cast<float>(x), static_cast<float>(y));
          to.push_back(from.back() + displacement.at<cv::Point2f>(y, x));
        }
      }
      cv::findFundamentalMat(from, to, cv::FM_RANSAC, 1.0, 0.99);
      seconds.wall.push_back(
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
      seconds.processor.push_back(static_cast<double>(std::clock() - processor_start) /
                                  CLOCKS_PER_SEC);
    }
    before = grey;
  }
  return seconds;
}

FixedWork::FixedWork() : a_(128, 416), b_(128, 416), flow_(cv::DISOpticalFlow::create()) {
  cv::RNG random(1);
  random.fill(a_, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(a_, a_, {}, 2.0);
  cv::warpAffine(a_, b_, cv::Matx23d(1, 0, 2, 0, 1, 1), a_.size());
}

double FixedWork::Milliseconds() {
  const auto start = std::chrono::steady_clock::now();
  cv::Mat flow;
  flow_->calc(a_, b_, flow);
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

}  // namespace egosieve::bench
