#include "tools/lab/evaluate_features/plain_ransac.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace egosieve::tools {
namespace {

constexpr float kRatio = 0.8F;
constexpr double kThresholdPixels = 1.0;
constexpr double kConfidence = 0.99;
constexpr size_t kFewest = 8;

struct Described {
  std::vector<cv::KeyPoint> places;
  cv::Mat descriptors;
};

Described Describe(const cv::Mat& image) {
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  Described result;
  cv::SIFT::create()->detectAndCompute(grey, cv::noArray(), result.places, result.descriptors);
  return result;
}

PlainRansac Estimate(const cv::Mat& first, const cv::Mat& second) {
  const Described a = Describe(first), b = Describe(second);
  PlainRansac result;
  std::vector<std::vector<cv::DMatch>> nearest;
  if (a.places.size() >= kFewest && b.places.size() >= kFewest) {
    cv::BFMatcher(cv::NORM_L2).knnMatch(a.descriptors, b.descriptors, nearest, 2);
  }
  std::vector<cv::Point2f> p, q;
  for (const std::vector<cv::DMatch>& two : nearest) {
    if (two.size() < 2 || !(two[0].distance < kRatio * two[1].distance)) continue;
    p.push_back(a.places[two[0].queryIdx].pt);
    q.push_back(b.places[two[0].trainIdx].pt);
    result.pairs.push_back({p.back().x, p.back().y, q.back().x, q.back().y});
  }
  if (p.size() < kFewest) return result;
  const cv::Mat f = cv::findFundamentalMat(p, q, cv::FM_RANSAC, kThresholdPixels, kConfidence);
  if (f.rows != 3 || f.cols != 3) return result;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result.fundamental(i, j) = f.at<double>(i, j);
  }
  return result;
}

}  // namespace

absl::StatusOr<PlainRansac> EstimateByPlainRansac(const cv::Mat& first, const cv::Mat& second) {
  try {
    PlainRansac result = Estimate(first, second);
    if (result.fundamental.isZero()) {
      return absl::FailedPreconditionError(
          absl::StrCat("no fundamental matrix from ", result.pairs.size(), " matches"));
    }
    return result;
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("plain RANSAC: ", error.err));
  }
}

}  // namespace egosieve::tools
