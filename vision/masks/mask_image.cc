#include "vision/masks/mask_image.h"

#include <opencv2/imgproc.hpp>

#include "vision/masks/edge_refinement.h"
#include "vision/masks/regions.h"

namespace egosieve::vision {
namespace {

constexpr int kHoleShare = 2000;  // picture's pixels divided by those of the largest filled hole
constexpr float kReach = 3.0f;    // pixels at working resolution

void FillHoles(cv::Mat1b& mask) {
  cv::Mat1i labels;
  cv::Mat stats, centres;
  const int count = cv::connectedComponentsWithStats(mask == 0, labels, stats, centres, 4, CV_32S);
  const int largest = static_cast<int>(mask.total()) / kHoleShare;
  std::vector<uint8_t> is_hole(count, 0);
  for (int i = 1; i < count; ++i) {
    const cv::Rect box(stats.at<int>(i, cv::CC_STAT_LEFT), stats.at<int>(i, cv::CC_STAT_TOP),
                       stats.at<int>(i, cv::CC_STAT_WIDTH), stats.at<int>(i, cv::CC_STAT_HEIGHT));
    const bool touches_border =
        box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows;
    is_hole[i] = !touches_border && stats.at<int>(i, cv::CC_STAT_AREA) <= largest;
  }
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (is_hole[labels(y, x)] != 0) mask(y, x) = 255;
    }
  }
}

}  // namespace

cv::Mat1b MaskOf(const cv::Mat1f& probability, const ObjectThresholds& thresholds,
                 const cv::Mat1b& excluded) {
  cv::Mat1f p = probability;
  if (!excluded.empty()) {
    p = probability.clone();
    p.setTo(0.0F, excluded);
  }
  cv::Mat1b mask = NumberObjects(p >= thresholds.low, p >= thresholds.high) != 0;
  FillHoles(mask);
  cv::medianBlur(mask, mask, 2 * WorkingStep(mask.size()) + 1);
  if (!excluded.empty()) mask.setTo(0, excluded);
  return mask;
}

cv::Mat1b SmallMask(const cv::Mat1b& mask, cv::Size size) {
  cv::Mat1b small;
  cv::resize(mask, small, size, 0, 0, cv::INTER_NEAREST);
  return small;
}

cv::Mat1w NumberPixels(const cv::Mat1w& small, cv::Mat1b& mask) {
  cv::Mat1w numbers = cv::Mat1w::zeros(mask.size());
  if (cv::countNonZero(small) == 0) {
    mask.setTo(0);
    return numbers;
  }
  cv::Mat1f distance;
  cv::Mat1w near = NearestNumbers(small, distance);
  near.setTo(0, distance > kReach);
  cv::Mat1w upsampled;
  cv::resize(near, upsampled, mask.size(), 0, 0, cv::INTER_NEAREST);
  upsampled.copyTo(numbers, mask);
  mask.setTo(0, numbers == 0);
  return numbers;
}

}  // namespace egosieve::vision
