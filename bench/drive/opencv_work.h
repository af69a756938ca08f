// Work of OpenCV alone, for comparison.
#ifndef EGOSIEVE_BENCH_DRIVE_OPENCV_WORK_H_
#define EGOSIEVE_BENCH_DRIVE_OPENCV_WORK_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

#include "absl/status/statusor.h"
#include "bench/drive/played_source.h"

namespace egosieve::bench {

struct OpenCvSeconds {
  std::vector<double> wall, processor;  // per frame, except the first
};

// The cost of dense flow between pictures (DIS) and of one fundamental matrix (RANSAC).
absl::StatusOr<OpenCvSeconds> MeasureOpenCv(const Clip& clip, int64_t count);

// A fixed piece of work, which shows how fast the machine itself is at the time.
class FixedWork {
 public:
  FixedWork();
  double Milliseconds();

 private:
  cv::Mat1b a_, b_;
  cv::Ptr<cv::DISOpticalFlow> flow_;
};

}  // namespace egosieve::bench

#endif  // EGOSIEVE_BENCH_DRIVE_OPENCV_WORK_H_
