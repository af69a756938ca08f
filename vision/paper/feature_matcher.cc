#include "vision/paper/feature_matcher.h"

#include <opencv2/features2d.hpp>

namespace egosieve::vision {
namespace {

constexpr float kRatio = 0.8F;

// Rows of the features of one kind.
cv::Range KeyPoints(const FeatureSet& set) { return {0, static_cast<int>(set.key_point_count)}; }
cv::Range Corners(const FeatureSet& set) {
  return {static_cast<int>(set.key_point_count), static_cast<int>(set.size())};
}

}  // namespace

std::vector<cv::DMatch> MatchFeatures(const FeatureSet& first, const FeatureSet& second) {
  const cv::BFMatcher matcher(cv::NORM_L2);
  std::vector<cv::DMatch> matches;
  for (const auto kind : {KeyPoints, Corners}) {
    const cv::Range a = kind(first), b = kind(second);
    if (a.empty() || b.empty()) continue;
    const cv::Mat of_first = first.descriptors.rowRange(a);
    const cv::Mat of_second = second.descriptors.rowRange(b);
    std::vector<std::vector<cv::DMatch>> forward;
    std::vector<cv::DMatch> backward;
    matcher.knnMatch(of_first, of_second, forward, 2);
    matcher.match(of_second, of_first, backward);
    for (const std::vector<cv::DMatch>& nearest : forward) {
      const cv::DMatch& best = nearest.front();
      const bool is_clear = nearest.size() < 2 || best.distance < kRatio * nearest.back().distance;
      if (!is_clear || backward[best.trainIdx].trainIdx != best.queryIdx) continue;
      matches.emplace_back(a.start + best.queryIdx, b.start + best.trainIdx, best.distance);
    }
  }
  return matches;
}

}  // namespace egosieve::vision
