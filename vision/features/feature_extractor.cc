#include "vision/features/feature_extractor.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "vision/features/corner_detector.h"
#include "vision/features/sift_describer.h"
#include "vision/features/spread.h"

namespace egosieve::vision {
namespace {

constexpr int kCornerBorder = 3;

std::vector<cv::KeyPoint> Thin(const std::vector<cv::KeyPoint>& key_points, cv::Size size,
                               int cell_pixels, int64_t count) {
  std::vector<cv::Point2f> positions;
  std::vector<float> responses;
  for (const cv::KeyPoint& key_point : key_points) {
    positions.push_back(key_point.pt);
    responses.push_back(key_point.response);
  }
  std::vector<cv::KeyPoint> kept;
  for (const int64_t i : SpreadOverGrid(positions, responses, size, cell_pixels, count)) {
    kept.push_back(key_points[i]);
  }
  return kept;
}

std::vector<cv::KeyPoint> CornersAsKeyPoints(const cv::Mat& grey, const FeatureOptions& options) {
  std::vector<cv::KeyPoint> key_points;
  for (const Corner& corner :
       DetectCorners(grey, static_cast<float>(options.corner_threshold), kCornerBorder)) {
    key_points.emplace_back(corner.position, static_cast<float>(options.corner_size_pixels), 0.0F,
                            corner.response);
  }
  return key_points;
}

void AppendPlaces(const std::vector<cv::KeyPoint>& key_points,
                  std::vector<DescribedPlace>& places) {
  for (const cv::KeyPoint& key_point : key_points) {
    places.push_back({key_point.pt, 0.5F * key_point.size, key_point.angle});
  }
}

}  // namespace

absl::Status FeatureOptions::Validate() const {
  return kernels::CheckOptions({
      {"count", count, count >= 0, "not be negative"},
      {"key_point_share", key_point_share, key_point_share >= 0 && key_point_share <= 1,
       "be from 0 to 1"},
      {"contrast_threshold", contrast_threshold, kernels::IsNotNegative(contrast_threshold),
       "not be negative"},
      {"corner_threshold", corner_threshold, kernels::IsNotNegative(corner_threshold),
       "not be negative"},
      {"corner_size_pixels", corner_size_pixels,
       corner_size_pixels > 0 && corner_size_pixels <= 100, "be in (0, 100]"},
      {"cell_pixels", cell_pixels, cell_pixels >= 1, "be positive"},
      {"threads", threads, threads >= 1 && threads <= 256, "be 1 to 256"},
  });
}

int64_t RequestedFeatureCount(const FeatureOptions& options, cv::Size size) {
  if (options.count > 0) return options.count;
  return std::llround(7000.0 * size.area() / (1242.0 * 375.0));
}

absl::StatusOr<FeatureSet> ExtractFeatures(const cv::Mat& grey, const FeatureOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  if (grey.empty() || grey.type() != CV_8UC1) {
    return absl::InvalidArgumentError("features need a grey 8-bit image that is not empty");
  }
  FeatureSet features;
  try {
    const int64_t count = RequestedFeatureCount(options, grey.size());
    const auto sift = cv::SIFT::create(0, 3, options.contrast_threshold, 10, 1.6, CV_8U);
    std::vector<cv::KeyPoint> key_points, corners = CornersAsKeyPoints(grey, options);
    if (options.key_point_share > 0) sift->detect(grey, key_points);

    const int64_t share = std::llround(options.key_point_share * static_cast<double>(count));
    const int64_t corner_count =
        std::min<int64_t>(static_cast<int64_t>(corners.size()), count - share);
    key_points = Thin(key_points, grey.size(), options.cell_pixels, count - corner_count);
    corners = Thin(corners, grey.size(), options.cell_pixels,
                   count - static_cast<int64_t>(key_points.size()));
    std::vector<DescribedPlace> places;
    AppendPlaces(key_points, places);
    AppendPlaces(corners, places);
    for (const DescribedPlace& place : places) features.positions.push_back(place.position);
    features.key_point_count = static_cast<int64_t>(key_points.size());
    features.descriptors.resize(places.size() * kSiftDescriptorBytes);
    if (!places.empty()) {
      SiftDescriber(grey).Describe(places, options.threads, features.descriptors.data());
    }
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("features: ", error.err));
  }
  return features;
}

}  // namespace egosieve::vision
