// Work of OpenCV alone, to compare with.
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
  std::vector<double> wall, processor;  // of each frame but the first
};

// What the motion of a picture's pixels (DIS flow) and one fundamental matrix (RANSAC) cost.
absl::StatusOr<OpenCvSeconds> MeasureOpenCv(const Clip& clip, int64_t count);

// A piece of work that never changes: what the machine itself was worth at the time.
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
