#include "vision/features/corner_tracks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "vision/features/corner_detector.h"
#include "vision/features/spread.h"

namespace egosieve::vision {
namespace {

constexpr int kWindow = 15;              // pixels
constexpr int kLevels = 4;               // of the pyramid, beyond the picture itself
constexpr float kMostReturn = 0.3f;      // pixels
constexpr int kBorder = 5;               // pixels
constexpr float kLeastResponse = 1e-5f;  // as in feature_extractor.h

std::vector<cv::Point2f> SpreadCorners(const cv::Mat& picture, int count) {
  std::vector<cv::Point2f> positions;
  std::vector<float> responses;
  for (const Corner& corner : DetectCorners(picture, kLeastResponse, kBorder)) {
    positions.push_back(corner.position);
    responses.push_back(corner.response);
  }
  const double side = std::sqrt(static_cast<double>(picture.size().area()) / count);
  std::vector<cv::Point2f> places;
  for (const int64_t i : SpreadOverGrid(positions, responses, picture.size(),
                                        std::max(1, static_cast<int>(std::lround(side))), count)) {
    places.push_back(positions[i]);
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

std::vector<CornerTrack> TrackCorners(const std::vector<cv::Mat>& pictures,
                                      const CornerTrackOptions& options) {
  std::vector<CornerTrack> tracks;
  if (pictures.empty()) return tracks;
  std::vector<cv::Point2f> places = SpreadCorners(pictures[0], options.corners);
  for (const cv::Point2f& place : places) tracks.push_back({place});
  std::vector<size_t> alive(tracks.size());
  for (size_t i = 0; i < alive.size(); ++i) alive[i] = i;

  const cv::Rect2f inside(kBorder, kBorder, pictures[0].cols - 2.0f * kBorder,
                          pictures[0].rows - 2.0f * kBorder);
  std::vector<cv::Mat> before = Pyramid(pictures[0]);
  for (size_t k = 1; k < pictures.size() && !alive.empty(); ++k) {
    std::vector<cv::Mat> pyramid = Pyramid(pictures[k]);
    std::vector<cv::Point2f> ends, back;
    std::vector<uint8_t> is_found, is_back;
    Follow(before, pyramid, places, ends, is_found);
    Follow(pyramid, before, ends, back, is_back);
    size_t kept = 0;
    for (size_t i = 0; i < alive.size(); ++i) {
      if (is_found[i] == 0 || is_back[i] == 0 || !inside.contains(ends[i]) ||
          !(cv::norm(back[i] - places[i]) < kMostReturn)) {
        continue;
      }
      tracks[alive[i]].push_back(ends[i]);
      alive[kept] = alive[i];
      places[kept] = ends[i];
      ++kept;
    }
    alive.resize(kept);
    places.resize(kept);
    before = std::move(pyramid);
  }
  std::erase_if(tracks, [&](const CornerTrack& track) {
    return static_cast<int>(track.size()) < options.least_pictures;
  });
  return tracks;
}

}  // namespace egosieve::vision
