#include "tools/evaluation/boundary.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_format.h"

namespace egosieve::tools {
namespace {

// Share of the pixels of `boundary` within `radius` of the other boundary.
double ShareNear(const cv::Mat1b& boundary, const cv::Mat1b& other, double radius) {
  const int pixels = cv::countNonZero(boundary);
  if (pixels == 0 || cv::countNonZero(other) == 0) return 0.0;
  cv::Mat1f distance;
  cv::distanceTransform(other == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  // Squared distances are integers, so 0.5 allows for float32's rounding of the root.
  const double limit = std::sqrt(radius * radius + 0.5);
  return static_cast<double>(cv::countNonZero(boundary & (distance <= limit))) / pixels;
}

}  // namespace

cv::Mat1b BoundaryOf(const cv::Mat1b& mask) {
  cv::Mat1b boundary = cv::Mat1b::zeros(mask.size());
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      const bool here = mask(y, x) != 0;
      const int right = std::min(x + 1, mask.cols - 1), below = std::min(y + 1, mask.rows - 1);
      if (here != (mask(y, right) != 0) || here != (mask(below, x) != 0) ||
          here != (mask(below, right) != 0)) {
        boundary(y, x) = 255;
      }
    }
  }
  return boundary;
}

absl::StatusOr<BoundaryScore> BoundaryF(const cv::Mat1b& prediction, const cv::Mat1b& truth,
                                        const cv::Mat1b& void_pixels, double bound_share) {
  if (prediction.size() != truth.size() ||
      (!void_pixels.empty() && void_pixels.size() != truth.size())) {
    return absl::InvalidArgumentError(
        absl::StrFormat("masks of %d x %d and %d x %d pixels cannot be compared", prediction.cols,
                        prediction.rows, truth.cols, truth.rows));
  }
  cv::Mat1b called = prediction.clone(), real = truth.clone();
  if (!void_pixels.empty()) {
    called.setTo(0, void_pixels);
    real.setTo(0, void_pixels);
  }
  const cv::Mat1b called_boundary = BoundaryOf(called), real_boundary = BoundaryOf(real);
  const bool nothing_called = cv::countNonZero(called_boundary) == 0;
  const bool nothing_real = cv::countNonZero(real_boundary) == 0;
  if (nothing_called && nothing_real) return BoundaryScore{1.0, 1.0, 1.0};
  const double radius = std::ceil(bound_share * std::hypot(truth.cols, truth.rows));
  BoundaryScore score;
  score.precision = ShareNear(called_boundary, real_boundary, radius);
  score.recall = ShareNear(real_boundary, called_boundary, radius);
  const double sum = score.precision + score.recall;
  score.f = sum > 0.0 ? 2.0 * score.precision * score.recall / sum : 0.0;
  return score;
}

}  // namespace egosieve::tools
