#include "vision/paper/feature_extractor.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <vector>

#include "absl/strings/str_cat.h"
#include "vision/features/corner_detector.h"

namespace egosieve::vision {
namespace {

constexpr double kKeyPointShare = 0.5;
constexpr double kContrastThreshold = 0.01;  // of SIFT's extrema, image in [0, 1], over 3 layers
constexpr float kCornerThreshold = 1e-5F;    // smallest eigenvalue, image in [0, 1]
constexpr int kCornerBorder = 3;
constexpr float kCornerSize = 8.0F;  // pixels, the diameter used to describe corners
// Their level, of octave 1 and layer 1 as cv::SIFT packs them: blurred by 4 pixels, the radius.
constexpr int kCornerOctave = 1 + (1 << 8);
constexpr int kCellPixels = 24;  // of the grid by which features are spread

std::vector<cv::KeyPoint> CornersAsKeyPoints(const cv::Mat& grey) {
  std::vector<cv::KeyPoint> corners = DetectCorners(grey, kCornerThreshold, kCornerBorder);
  for (cv::KeyPoint& corner : corners) {
    corner.size = kCornerSize;
    corner.angle = 0.0F;
    corner.octave = kCornerOctave;
  }
  return corners;
}

}  // namespace

absl::StatusOr<FeatureSet> ExtractFeatures(const cv::Mat& grey) {
  if (grey.empty() || grey.type() != CV_8UC1) {
    return absl::InvalidArgumentError("features need a grey 8-bit image that is not empty");
  }
  FeatureSet features;
  try {
    const int64_t count = std::llround(7000.0 * grey.size().area() / (1242.0 * 375.0));
    const auto sift = cv::SIFT::create(0, 3, kContrastThreshold);
    std::vector<cv::KeyPoint> key_points, corners = CornersAsKeyPoints(grey);
    sift->detect(grey, key_points);

    const int64_t share = std::llround(kKeyPointShare * static_cast<double>(count));
    const int64_t corner_count =
        std::min<int64_t>(static_cast<int64_t>(corners.size()), count - share);
    key_points = SpreadOverGrid(key_points, grey.size(), kCellPixels, count - corner_count);
    corners = SpreadOverGrid(corners, grey.size(), kCellPixels,
                             count - static_cast<int64_t>(key_points.size()));
    features.key_point_count = static_cast<int64_t>(key_points.size());
    key_points.insert(key_points.end(), corners.begin(), corners.end());
    for (const cv::KeyPoint& place : key_points) features.positions.push_back(place.pt);
    if (!key_points.empty()) sift->compute(grey, key_points, features.descriptors);
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("features: ", error.err));
  }
  return features;
}

}  // namespace egosieve::vision
