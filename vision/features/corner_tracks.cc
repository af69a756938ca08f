#include "vision/features/corner_tracks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "vision/features/corner_detector.h"
#include "vision/statistics/order_statistics.h"

namespace egosieve::vision {
namespace {

constexpr int kWindow = 15;              // pixels
constexpr int kLevels = 4;               // of the pyramid, in addition to the picture itself
constexpr float kMostReturn = 0.3f;      // pixels
constexpr int kBorder = 5;               // pixels
constexpr float kLeastResponse = 1e-5f;  // as in feature_extractor.h

std::vector<cv::Point2f> SpreadCorners(const cv::Mat& picture, int count) {
  const double side = std::sqrt(static_cast<double>(picture.size().area()) / count);
  std::vector<cv::Point2f> places;
  for (const cv::KeyPoint& corner :
       SpreadOverGrid(DetectCorners(picture, kLeastResponse, kBorder), picture.size(),
                      std::max(1, static_cast<int>(std::lround(side))), count)) {
    places.push_back(corner.pt);
  }
  return places;
}

std::vector<cv::Mat> Pyramid(const cv::Mat& picture) {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(picture, pyramid, {kWindow, kWindow}, kLevels);
  return pyramid;
}

void Follow(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to,
            const std::vector<cv::Point2f>& starts, std::vector<cv::Point2f>& ends,
            std::vector<uint8_t>& is_found) {
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01);
  cv::calcOpticalFlowPyrLK(from, to, starts, ends, is_found, cv::noArray(), {kWindow, kWindow},
                           kLevels, criteria);
}

}  // namespace

CornerTracker CornerTracker::Of(std::vector<CornerTrack> tracks, int pictures) {
  CornerTracker tracker;
  tracker.pictures_ = pictures;
  tracker.tracks_ = std::move(tracks);
  for (size_t i = 0; i < tracker.tracks_.size(); ++i) {
    if (static_cast<int>(tracker.tracks_[i].size()) == pictures) tracker.alive_.push_back(i);
  }
  return tracker;
}

void CornerTracker::SetLastPicture(const cv::Mat& picture) { pyramid_ = Pyramid(picture); }

void CornerTracker::Add(const cv::Mat& picture) {
  std::vector<cv::Mat> pyramid = Pyramid(picture);
  if (++pictures_ == 1) {
    for (const cv::Point2f& place : SpreadCorners(picture, corners_)) {
      alive_.push_back(tracks_.size());
      tracks_.push_back({place});
    }
  } else if (!alive_.empty()) {
    std::vector<cv::Point2f> places, ends, back;
    for (const size_t i : alive_) places.push_back(tracks_[i].back());
    std::vector<uint8_t> is_found, is_back;
    Follow(pyramid_, pyramid, places, ends, is_found);
    Follow(pyramid, pyramid_, ends, back, is_back);
    const cv::Rect2f inside(kBorder, kBorder, picture.cols - 2.0f * kBorder,
                            picture.rows - 2.0f * kBorder);
    std::vector<size_t> kept;
    for (size_t k = 0; k < alive_.size(); ++k) {
      if (is_found[k] == 0 || is_back[k] == 0 || !inside.contains(ends[k]) ||
          !(cv::norm(back[k] - places[k]) < kMostReturn)) {
        continue;
      }
      tracks_[alive_[k]].push_back(ends[k]);
      kept.push_back(alive_[k]);
    }
    alive_ = std::move(kept);
  }
  pyramid_ = std::move(pyramid);
}

double CornerTracker::MedianMotion() const {
  std::vector<double> motions;
  for (const size_t i : alive_) motions.push_back(cv::norm(tracks_[i].back() - tracks_[i].front()));
  return motions.empty() ? 0.0 : MedianInPlace(motions);
}

}  // namespace egosieve::vision
