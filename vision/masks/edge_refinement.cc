#include "vision/masks/edge_refinement.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>

namespace egosieve::vision {
namespace {

constexpr int kLongestWorkingSide = 640;
constexpr float kDoubt = 0.002f;
constexpr double kEdgeReach = 0.05;  // of the picture's longer side
constexpr double kEdgeLevels = 5.0;  // of 255

}  // namespace

int WorkingStep(cv::Size size) {
  return std::max(
      1, (std::max(size.width, size.height) + kLongestWorkingSide - 1) / kLongestWorkingSide);
}

cv::Mat ToWorkingSize(const cv::Mat& image, int step) {
  if (step == 1) return image.clone();
  cv::Mat small;
  cv::resize(image, small, {(image.cols + step - 1) / step, (image.rows + step - 1) / step}, 0, 0,
             cv::INTER_AREA);
  return small;
}

cv::Mat1f LogOdds(const cv::Mat1f& probability) {
  const cv::Mat1f p = cv::max(cv::min(probability, 1.0f - kDoubt), kDoubt);
  cv::Mat1f odds = p / (1.0f - p);
  cv::log(odds, odds);
  return odds;
}

cv::Mat1f Probability(const cv::Mat1f& log_odds) {
  cv::Mat1f inverse;
  cv::exp(-log_odds, inverse);
  return 1.0f / (1.0f + inverse);
}

cv::Mat1f RefineProbability(const cv::Mat3b& image, const cv::Mat1f& log_odds) {
  cv::Mat1f full;
  cv::resize(log_odds, full, image.size(), 0, 0, cv::INTER_LINEAR);
  const cv::Mat1f rough = Probability(full);
  const double reach_pixels = kEdgeReach * std::max(image.cols, image.rows);
  cv::Mat1f smooth;
  cv::ximgproc::fastGlobalSmootherFilter(image, rough, smooth, reach_pixels * reach_pixels,
                                         kEdgeLevels);
  return cv::max(cv::min(smooth, 1.0f - kDoubt), kDoubt);
}

}  // namespace egosieve::vision
