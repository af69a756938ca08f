#include "vision/masks/edge_refinement.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/masks/tonal_range.h"

namespace egosieve::vision {
namespace {

constexpr int kLongestWorkingSide = 640;
constexpr float kDoubt = 0.002f;
constexpr double kEdgeReach = 0.05;  // of the picture's longer side
constexpr double kEdgeLevels = 5.0;  // of 255
constexpr int kSweeps = 3;           // along columns and rows; a quarter of the weight each time

// exp(-|I_x - I_y| / levels) of each pixel x and the pixel y below it; 0 in the last row.
cv::Mat1f LikenessBelow(const cv::Mat3b& image, float levels) {
  cv::Mat1f likeness(image.size(), 0.0f);
  for (int y = 0; y + 1 < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      likeness(y, x) = -std::sqrt(SquaredDifference(image(y, x), image(y + 1, x))) / levels;
    }
  }
  cv::exp(likeness, likeness);
  likeness.row(image.rows - 1) = 0.0f;
  return likeness;
}

// Solves fgs along each column for itself, in place: a tridiagonal system by Thomas's algorithm.
void SmoothColumns(const cv::Mat1f& likeness, float weight, cv::Mat1f& values) {
  using Row = Eigen::Map<Eigen::ArrayXf>;
  cv::Mat1f ratios(values.size());
  Eigen::ArrayXf above = Eigen::ArrayXf::Zero(values.cols), ratio = above, value = above;
  for (int y = 0; y < values.rows; ++y) {
    const Eigen::ArrayXf below =
        weight * Eigen::Map<const Eigen::ArrayXf>(likeness[y], values.cols);
    const Eigen::ArrayXf pivot = 1.0f + below + above * (1.0f - ratio);
    ratio = below / pivot;
    value = (Row(values[y], values.cols) + above * value) / pivot;
    Row(ratios[y], values.cols) = ratio;
    Row(values[y], values.cols) = value;
    above = below;
  }
  for (int y = values.rows - 2; y >= 0; --y) {
    value = Row(values[y], values.cols) + Row(ratios[y], values.cols) * value;
    Row(values[y], values.cols) = value;
  }
}

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
  cv::Mat1f probability = Probability(full);
  const double reach = kEdgeReach * std::max(image.cols, image.rows);
  auto weight = static_cast<float>(reach * reach);
  const auto levels = static_cast<float>(kEdgeLevels / TonalRangeOf({image}).Gain());
  const cv::Mat1f below = LikenessBelow(image, levels), right = LikenessBelow(image.t(), levels);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    probability = probability.t();
    SmoothColumns(right, weight, probability);
    probability = probability.t();
    SmoothColumns(below, weight, probability);
    weight /= 4.0f;
  }
  return cv::max(cv::min(probability, 1.0f - kDoubt), kDoubt);
}

}  // namespace egosieve::vision
