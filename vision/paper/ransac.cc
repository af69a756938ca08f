#include "vision/paper/ransac.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "vision/geometry/mix_seed.h"

namespace egosieve::vision {
namespace {

using Points = std::vector<cv::Point2f>;

constexpr float kLeastWidth = 2.0F;  // pixels, of the places in an image

bool LieOnALine(const Points& points) {
  const cv::Size2f box = cv::minAreaRect(points).size;
  return std::min(box.width, box.height) < kLeastWidth;
}

// Calls find(points of the first image, of the second, mask, parameters), either of OpenCV's.
template <typename Find>
absl::StatusOr<Eigen::Matrix3d> Estimate(const std::vector<PointPair>& pairs,
                                         double threshold_pixels, uint64_t seed, const char* name,
                                         size_t sample_size, const Find& find) {
  Points first, second;
  for (const PointPair& p : pairs) {
    if (!std::isfinite(p.x1 + p.y1 + p.x2 + p.y2)) continue;
    first.emplace_back(p.x1, p.y1);
    second.emplace_back(p.x2, p.y2);
  }
  if (first.size() < sample_size) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": ", first.size(), " point pairs, ", sample_size, " are needed"));
  }
  cv::UsacParams parameters;
  parameters.threshold = threshold_pixels;
  parameters.confidence = 0.9999;
  parameters.maxIterations = 2000;
  parameters.loMethod = cv::LOCAL_OPTIM_INNER_AND_ITER_LO;
  parameters.loIterations = 10;
  parameters.loSampleSize = 30;
  parameters.randomGeneratorState =
      static_cast<int>(MixSeed(seed, 0, 0) % std::numeric_limits<int>::max());
  cv::Mat matrix;
  try {
    if (!LieOnALine(first) && !LieOnALine(second)) {
      matrix = find(first, second, cv::noArray(), parameters);
    }
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat(name, ": ", error.err));
  }
  if (matrix.size() != cv::Size(3, 3) || !cv::checkRange(matrix)) {
    return absl::NotFoundError(
        absl::StrCat(name, ": the ", first.size(), " point pairs do not determine one"));
  }
  Eigen::Matrix3d result;
  cv::cv2eigen(matrix, result);
  return result;
}

}  // namespace

absl::StatusOr<Eigen::Matrix3d> EstimateFundamental(const std::vector<PointPair>& pairs,
                                                    double threshold_pixels, uint64_t seed) {
  return Estimate(pairs, threshold_pixels, seed, "fundamental matrix", 7,
                  [](const Points& first, const Points& second, cv::OutputArray mask,
                     const cv::UsacParams& parameters) {
                    return cv::findFundamentalMat(first, second, mask, parameters);
                  });
}

absl::StatusOr<Eigen::Matrix3d> EstimateHomography(const std::vector<PointPair>& pairs,
                                                   double threshold_pixels, uint64_t seed) {
  return Estimate(pairs, threshold_pixels, seed, "homography", 4,
                  [](const Points& first, const Points& second, cv::OutputArray mask,
                     const cv::UsacParams& parameters) {
                    return cv::findHomography(first, second, mask, parameters);
                  });
}

}  // namespace egosieve::vision
