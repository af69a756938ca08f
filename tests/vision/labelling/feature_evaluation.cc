#include "tests/vision/labelling/feature_evaluation.h"

#include <cmath>
#include <vector>

#include "tests/testing/area_under_curve.h"

namespace egosieve::vision {

double AreaUnderMask(const LabelledFrame& frame, const cv::Mat& mask) {
  constexpr int kMover = 255, kVoid = 128;
  std::vector<double> labels;
  std::vector<bool> is_mover;
  for (int64_t i = 0; i < frame.size(); ++i) {
    const int x = static_cast<int>(std::lround(frame.positions[2 * i]));
    const int y = static_cast<int>(std::lround(frame.positions[2 * i + 1]));
    if (x < 0 || y < 0 || x >= mask.cols || y >= mask.rows) continue;
    const int truth = mask.at<uint8_t>(y, x);
    if (truth == kVoid) continue;
    is_mover.push_back(truth == kMover);
    labels.push_back(frame.probability[i]);
  }
  return AreaUnderCurve(labels, is_mover);
}

}  // namespace egosieve::vision
